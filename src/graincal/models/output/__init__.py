"""Output that a program declares: which of its columns is which quantity, and what that gives at the reference's rows."""

from graincal.models.output.columns import Column
from graincal.models.output.output import STANDARD_OUTPUT, Output

__all__ = ["STANDARD_OUTPUT", "Column", "Output"]
