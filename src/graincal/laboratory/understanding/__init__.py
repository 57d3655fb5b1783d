"""What a laboratory file is of: what its columns prove, and what has to be asked."""

from graincal.laboratory.understanding.case import Known
from graincal.laboratory.understanding.understanding import NotUnderstood, Understanding, understand

__all__ = ["Known", "NotUnderstood", "Understanding", "understand"]
