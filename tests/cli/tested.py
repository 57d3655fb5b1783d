"""A good calibration file of each kind of test, to be spoilt in one place."""

from pathlib import Path

import numpy as np

from graincal import Packing, demo

PACKING = Path(demo.__file__).with_name("packing_500.csv")
VOID_RATIO = Packing.read(PACKING).void_ratio
PRESSURE = 200e3

STRAIN = np.linspace(0, 0.1, 11)
RATIO = 1 + 2.5 * STRAIN / (0.005 + STRAIN)
VOLUMETRIC = 0.3 * STRAIN * np.exp(-STRAIN / 0.02) - 0.3 * STRAIN**2 / (0.05 + STRAIN)
COLUMNS = {
    "axial_strain": STRAIN,
    "stress_ratio": RATIO,
    "volumetric_strain": VOLUMETRIC,
    "void_ratio": (1 + VOID_RATIO) * np.exp(-VOLUMETRIC) - 1,
    "deviatoric_stress [Pa]": PRESSURE * (RATIO - 1),
}

TRIAXIAL = """
[parameters]
log_E = { range = [7, 9], unit = "log10 Pa" }
phi   = { range = [10, 50], unit = "deg" }

[[experiment]]
name        = "drained"
control     = "axial_strain"
observables = { stress_ratio = {}, volumetric_strain = {}, void_ratio = {} }
reference   = { file = "lab.csv", strain = "logarithmic" }
model       = { kind = "triaxial", packing = "PACKING", confining_pressure = 200e3, fixed = { nu = 0.2, beta_m = 0.1, eta_m = 0.3 } }

[run]
workers = 1
"""


def _with(columns, text, *replacements):
    for old, new in replacements:
        assert old in text, old
        text = text.replace(old, new)
    return columns, text


DRAINED = (COLUMNS, TRIAXIAL)
EXTENSION = _with(
    {"axial_extension": STRAIN, "stress_ratio": 1 / RATIO}, TRIAXIAL,
    ('"axial_strain"', '"axial_extension"'), ("stress_ratio = {}, volumetric_strain = {}, void_ratio = {}", "stress_ratio = {}"), (', strain = "logarithmic"', ""),
)  # fmt: skip
_PORE = PRESSURE * 0.6 * STRAIN / (0.01 + STRAIN)
UNDRAINED = _with(
    {"axial_strain": STRAIN, "deviatoric_stress [Pa]": (PRESSURE - _PORE) * (RATIO - 1), "excess_pore_pressure [Pa]": _PORE, "volumetric_strain": 0 * STRAIN, "stress_ratio": RATIO}, TRIAXIAL,
    ('kind = "triaxial"', 'kind = "undrained"'), ("stress_ratio = {}, volumetric_strain = {}, void_ratio = {}", "deviatoric_stress = {}, excess_pore_pressure = {}"),
)  # fmt: skip
CONSTANT_MEAN = _with(
    {"axial_strain": STRAIN, "mean_stress [Pa]": 0 * STRAIN + PRESSURE, "deviatoric_stress [Pa]": 3 * PRESSURE * (RATIO - 1) / (RATIO + 2)}, TRIAXIAL,
    ('kind = "triaxial"', 'kind = "constant-mean-stress"'), ("stress_ratio = {}, volumetric_strain = {}, void_ratio = {}", "mean_stress = {}, deviatoric_stress = {}"),
)  # fmt: skip
_STRESS = np.geomspace(2e4, 2e6, 9)
OEDOMETRIC = _with(
    {"axial_stress [Pa]": _STRESS, "void_ratio": VOID_RATIO - 0.02 * np.log10(_STRESS / 2e4), "lateral_stress [Pa]": 0.45 * _STRESS}, TRIAXIAL,
    ('kind = "triaxial"', 'kind = "oedometric"'), ("200e3", "20e3"), ('"axial_strain"', '"axial_stress"'), (', strain = "logarithmic"', ""),
    ("stress_ratio = {}, volumetric_strain = {}, void_ratio = {}", "void_ratio = {}, lateral_stress = {}"),
)  # fmt: skip


def write(folder, case, columns=None, replacements=()):
    """The file of a case in a folder, with other columns {name: function of the values, or None to leave it out} and other text, (old, new). Returns its path."""
    values, text = case
    values = dict(values)
    for name, change in (columns or {}).items():
        (key,) = [each for each in values if each.split()[0] == name]
        values[key] = change(values[key])
    rows = [",".join(f"{value:.10g}" for value in row) for row in zip(*values.values())]
    (folder / "lab.csv").write_text("\n".join([",".join(values), *rows]) + "\n")
    path = folder / "calibration.toml"
    path.write_text(_with(None, text, *replacements)[1].replace("PACKING", str(PACKING)))
    return path
