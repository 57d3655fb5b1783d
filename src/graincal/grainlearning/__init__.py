"""Runs that GrainLearning kept, another tool for calibrating DEM models: their parameters and curves, as its files have them."""

from graincal.grainlearning.folder import ForeignRun, read_folder

__all__ = ["ForeignRun", "read_folder"]
