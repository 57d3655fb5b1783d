"""What an evaluation is: a built-in test, or anybody else's function."""

from graincal.models.element_tests import TESTS, ConstantMeanStressTest, IsotropicTest, OedometricTest, TableTest, TriaxialTest, UndrainedTest
from graincal.models.python import PythonModel
from graincal.models.stress_path import StressPathTest

__all__ = [
    "TESTS",
    "ConstantMeanStressTest",
    "IsotropicTest",
    "OedometricTest",
    "PythonModel",
    "StressPathTest",
    "TableTest",
    "TriaxialTest",
    "UndrainedTest",
]
