"""What Hartmann, Cheng, Thornton (2022), Computers and Geotechnics 141, 104491, took and found: numbers that several studies share."""

from __future__ import annotations

from collections.abc import Mapping

PARAMETERS = ("log_E", "nu", "phi", "beta_m", "eta_m")

BOXES: Mapping[str, tuple[float, float]] = {"small": (8, 10), "mid": (7, 11), "wide": (6, 12), "extra wide": (5, 13)}
"""Table 7: the ranges of log E. The other parameters keep those of Table 2."""

DENSITY_SCALING = 1e3
"""At every confining pressure."""

TRUTH = (8.7201937725, 0.22713583282, 28.098831336, 0.079088789751, 0.56921192356)
"""The parameters of the synthetic reference, with every digit; Table 6 prints four."""

CALIBRATED = (8.733, 0.186, 28.530, 0.095, 0.797)
"""Table 6: what the paper calibrated on the synthetic reference."""

TOYOURA = (8.782, 0.161, 30.626, 0.071, 0.885)
"""Table 3: what the paper calibrated on Toyoura sand at 0.5 MPa."""

S_LIMIT = 0.01
"""The only criterion of stopping in sections 3 and 4."""

MOST_ITERATIONS = 101
"""Iteration 0 counted: two of the paper's runs were stopped by hand after iteration 100."""
