"""Laboratory files: reading one into a reference by what is said of it, and looking at an unknown one to propose what to say."""

from graincal.laboratory.decisions import Decision, Question
from graincal.laboratory.describe import describe
from graincal.laboratory.reading import Test, read_test
from graincal.laboratory.understanding import Known, NotUnderstood, Understanding, understand

__all__ = ["Decision", "Known", "NotUnderstood", "Question", "Test", "Understanding", "describe", "read_test", "understand"]
