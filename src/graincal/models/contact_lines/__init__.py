"""The contact law of a calibrated model, written as lines of other DEM programs: a file for each program."""
