"""Packings as YADE was given them."""

import numpy as np


def centres_as_they_stand(path):
    """Positions (N, 3), radii (N,) and edges (3, 3) of a packing file, without wrapping centres into the cell: the record of YADE's steps depends on where
    the origin lies, and graincal's motion as YADE's does too."""
    lengths = [float(text) for text in path.read_text().splitlines()[0].split("cell lengths:")[1].split()]
    table = np.loadtxt(path, delimiter=",", skiprows=2)
    return np.ascontiguousarray(table[:, :3]), np.ascontiguousarray(table[:, 3]), np.diag(lengths)
