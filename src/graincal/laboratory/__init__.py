"""Laboratory files: reading one into a reference by what is said of it, and looking at an unknown one to propose what to say."""

from graincal.laboratory.look import LaboratoryColumn, LaboratoryFile, look
from graincal.laboratory.propose import describe, propose
from graincal.laboratory.reading import read_reference

__all__ = ["LaboratoryColumn", "LaboratoryFile", "describe", "look", "propose", "read_reference"]
