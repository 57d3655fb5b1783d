"""What a laboratory file is of: what its columns prove, and what has to be asked."""

from graincal.laboratory.understanding.case import Known, NotUnderstood
from graincal.laboratory.understanding.understanding import Understanding, understand

__all__ = ["Known", "NotUnderstood", "Understanding", "understand"]
