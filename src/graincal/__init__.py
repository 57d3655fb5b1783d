"""graincal: Bayesian calibration of Discrete Element Method models against laboratory tests."""

from importlib.metadata import version

__version__ = version("graincal")
