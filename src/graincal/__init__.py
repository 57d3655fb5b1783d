"""graincal: Bayesian calibration of Discrete Element Method models against laboratory tests."""

from importlib.metadata import version

from graincal.data import Failure, InputError, ParameterSpace, Reference, Response, Samples
from graincal.dem.packing import Packing
from graincal.models import TriaxialTest

__version__ = version("graincal")

__all__ = ["Failure", "InputError", "Packing", "ParameterSpace", "Reference", "Response", "Samples", "TriaxialTest"]
