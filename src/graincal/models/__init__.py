"""What an evaluation is: the built-in test, or anybody else's function."""

from graincal.models.python import PythonModel
from graincal.models.triaxial import TriaxialTest

__all__ = ["PythonModel", "TriaxialTest"]
