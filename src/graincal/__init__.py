"""graincal: Bayesian calibration of Discrete Element Method models against laboratory tests."""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING

from graincal.data import Failure, InputError, MeasurementError, ParameterSpace, Reference, Response, Samples
from graincal.dem.packing import Packing
from graincal.dem.stress_path_table import StressPathTable
from graincal.models import ConstantMeanStressTest, IsotropicTest, OedometricTest, PythonModel, TableTest, TriaxialTest, UndrainedTest

if TYPE_CHECKING:
    from graincal.campaign import Experiment, FolderError, Result, calibrate, resume
    from graincal.inference import IterativeBayesianFilter, Posterior, PosteriorFilter, SequentialMonteCarloFilter, Stop

__version__ = version("graincal")

__all__ = [
    "ConstantMeanStressTest",
    "Experiment",
    "Failure",
    "FolderError",
    "InputError",
    "IsotropicTest",
    "IterativeBayesianFilter",
    "MeasurementError",
    "OedometricTest",
    "Packing",
    "ParameterSpace",
    "Posterior",
    "PosteriorFilter",
    "PythonModel",
    "Reference",
    "Response",
    "Result",
    "Samples",
    "SequentialMonteCarloFilter",
    "Stop",
    "StressPathTable",
    "TableTest",
    "TriaxialTest",
    "UndrainedTest",
    "calibrate",
    "resume",
]


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])


def __getattr__(name: str):
    # Statistics take a second to import, which worker processes and most commands need not wait for.
    for module in ("graincal.inference", "graincal.campaign") if name in __all__ else ():
        if hasattr(found := import_module(module), name):
            return getattr(found, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
