"""A soil in two formulas, to calibrate in moments: a hyperbolic stress-strain curve and a parabola of volumetric strain."""

import shutil

import numpy as np

from graincal import ParameterSpace, PythonModel, Reference

STRAIN = np.linspace(0, 0.2, 11)
TRUTH = np.array([0.6, 0.4])
SPACE = ParameterSpace({"strength": (0, 1), "dilatancy": (0, 1)})


def respond(theta):
    """Stress ratio and volumetric strain, and a quantity besides. Fails where the soil is strong and dilatant both."""
    strength, dilatancy = theta
    if strength + dilatancy > 1.5:
        raise ArithmeticError("no equilibrium")
    return {
        "stress_ratio": 1 + 3 * strength * STRAIN / (0.02 + STRAIN),
        "volumetric_strain": 0.1 * STRAIN - dilatancy * STRAIN**2,
        "void_ratio": 0.7 + dilatancy * STRAIN,
    }


def reference(theta=TRUTH, names=("stress_ratio", "volumetric_strain")):
    """The curves at a theta."""
    return Reference(STRAIN, {name: respond(theta)[name] for name in names})


def model():
    """The soil as a model."""
    return PythonModel(respond)


CALIBRATION = """
[parameters]
strength  = { range = [0, 1] }
dilatancy = { range = [0, 1], unit = "-" }

[[experiment]]
name        = "drained"
reference   = "reference.csv"
observables = { stress_ratio = { variance_share = 0.5 }, volumetric_strain = { variance_share = 0.5 } }
model       = { kind = "python", function = "soil:respond" }

[filter]
method = "iterative-bayesian"
alpha = 10

[stop]
max_iterations = 3
s = false
gl_error_increment = false
error = false
error_increment = false

[run]
workers = 1
seed = 3
"""

THE_PAPERS = 'method = "iterative-bayesian"\nalpha = 10'
"""Its filter, in the place of which another may stand."""


def write_calibration(folder, *replacements):
    """A calibration file, its reference and its model in a folder; each replacement is (old, new). Returns the file's path."""
    text = CALIBRATION
    for old, new in replacements:
        assert old in text, old
        text = text.replace(old, new)
    curves = reference().observables
    rows = [",".join(map(repr, map(float, row))) for row in zip(STRAIN, *curves.values())]
    (folder / "reference.csv").write_text("\n".join(["axial_strain," + ",".join(curves), *rows]) + "\n")
    shutil.copy(__file__, folder / "soil.py")
    path = folder / "calibration.toml"
    path.write_text(text)
    return path
