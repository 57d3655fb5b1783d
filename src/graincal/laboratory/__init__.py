"""Laboratory files: reading one into a reference by what is said of it."""

from graincal.laboratory.reading import read_reference

__all__ = ["read_reference"]
