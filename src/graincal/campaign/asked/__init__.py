"""What was asked: a calibration, its experiments, and what is assumed of them."""
