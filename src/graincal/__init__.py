"""graincal: Bayesian calibration of Discrete Element Method models against laboratory tests."""

import logging
from typing import TYPE_CHECKING, Any

from graincal.data import Failure, InputError, MeasurementError, ParameterSpace, Reference, Response, Samples
from graincal.lazily import exported

if TYPE_CHECKING:
    from graincal.campaign import CandidateTest, Experiment, FolderError, Step, advise, calibrate, compare, explore, predict, resume
    from graincal.dem.packing import Packing
    from graincal.dem.stress_path_table import StressPathTable
    from graincal.inference import IterativeBayesianFilter, Posterior, PosteriorFilter, SequentialMonteCarloFilter, Stop, curve_error
    from graincal.models import (
        ByHandModel,
        CommandModel,
        ConstantMeanStressTest,
        IsotropicTest,
        OedometricTest,
        PythonModel,
        TableTest,
        TriaxialTest,
        UndrainedTest,
    )
    from graincal.models.simulate import simulate
    from graincal.result import Result

    __version__: str

__all__ = [
    "ByHandModel",
    "CandidateTest",
    "CommandModel",
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
    "Step",
    "Stop",
    "StressPathTable",
    "TableTest",
    "TriaxialTest",
    "UndrainedTest",
    "advise",
    "calibrate",
    "compare",
    "curve_error",
    "explore",
    "predict",
    "resume",
    "simulate",
]


# What a campaign's log says goes to this logger too; without a handler of a program's own it is silent.
logging.getLogger("graincal").addHandler(logging.NullHandler())


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])


_find = exported(
    __name__,
    {
        "graincal.campaign": ["CandidateTest", "Experiment", "FolderError", "Step", "advise", "calibrate", "compare", "explore", "predict", "resume"],
        "graincal.dem.packing": ["Packing"],
        "graincal.dem.stress_path_table": ["StressPathTable"],
        "graincal.inference": ["IterativeBayesianFilter", "Posterior", "PosteriorFilter", "SequentialMonteCarloFilter", "Stop", "curve_error"],
        "graincal.models": [
            "ByHandModel",
            "CommandModel",
            "ConstantMeanStressTest",
            "IsotropicTest",
            "OedometricTest",
            "PythonModel",
            "TableTest",
            "TriaxialTest",
            "UndrainedTest",
        ],
        "graincal.models.simulate": ["simulate"],
        "graincal.result": ["Result"],
    },
)


if not TYPE_CHECKING:
    # A type checker has the names by the imports above, and would take any other for one of these.
    def __getattr__(name: str) -> Any:
        if name == "__version__":
            from importlib.metadata import version

            return version("graincal")
        return _find(name)
