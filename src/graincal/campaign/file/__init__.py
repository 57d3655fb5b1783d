"""The calibration file: what it says, whether it can be right, and what it leads one to expect."""
