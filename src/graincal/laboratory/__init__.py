"""Laboratory files: reading one into a reference by what is said of it, and looking at an unknown one to propose what to say."""

from graincal.laboratory.decisions import Decision, Question
from graincal.laboratory.describe import describe
from graincal.laboratory.propose import Preparation, propose, propose_unknown
from graincal.laboratory.reading import read_reference
from graincal.laboratory.understanding import Known, NotUnderstood, Understanding, understand

__all__ = ["Decision", "Known", "NotUnderstood", "Preparation", "Question", "Understanding", "describe", "propose", "propose_unknown", "read_reference", "understand"]
