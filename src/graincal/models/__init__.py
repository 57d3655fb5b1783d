"""What an evaluation is: a built-in test, or anybody else's function or program."""

from typing import TYPE_CHECKING

from graincal.lazily import exported
from graincal.models.by_hand import ByHandModel
from graincal.models.element_tests import TESTS, ConstantMeanStressTest, IsotropicTest, OedometricTest, TableTest, TriaxialTest, UndrainedTest
from graincal.models.model import Model
from graincal.models.stress_path import StressPathTest

if TYPE_CHECKING:
    from graincal.models.command.model import CommandModel
    from graincal.models.python import PythonModel
    from graincal.models.yade.model import YadeModel

__all__ = [
    "TESTS",
    "ByHandModel",
    "CommandModel",
    "ConstantMeanStressTest",
    "IsotropicTest",
    "Model",
    "OedometricTest",
    "PythonModel",
    "StressPathTest",
    "TableTest",
    "TriaxialTest",
    "UndrainedTest",
    "YadeModel",
]

__getattr__ = exported(
    __name__, {"graincal.models.command.model": ["CommandModel"], "graincal.models.python": ["PythonModel"], "graincal.models.yade.model": ["YadeModel"]}
)
