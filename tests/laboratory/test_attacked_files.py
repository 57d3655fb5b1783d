"""Files that a program may well read wrongly in silence: each is read right, refused in a sentence, or asked about.

Most are the same drained test at 100 kPa, in whatever a laboratory may write: σ1/σ3 goes from 1 over 3.95 to 3.673, and the volumetric strain to -0.0133, logarithmic and contraction positive.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from generated.expectation import Expectation, Figures
from generated.outcome import read
from generated.packing import packing

STRAIN = np.array([0, 0.1, 0.2, 0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15])
Q = 330 * STRAIN / (0.6 + STRAIN) - 5 * np.clip(STRAIN - 5, 0, None)
VOLUME = 0.5 * STRAIN * np.exp(-STRAIN / 1.2) - 0.28 * np.clip(STRAIN - 1, 0, None) * np.exp(-STRAIN / 14)
STRESS = np.array([12.5, 25, 50, 100, 200, 400, 800, 1600])
SETTLED = np.array([0.05, 0.11, 0.2, 0.33, 0.5, 0.72, 1.0, 1.35])
VOID_RATIO = 0.72 - 1.72 * SETTLED / 20

AT_100 = "--confining-pressure 100e3"
RATIO = "stress_ratio 1 3.673"
DRAINED = f"triaxial 100e3 {RATIO} volumetric_strain 0 -0.0133"
COMPRESSED = "oedometric 12.5e3 void_ratio 0.7157 0.6039"
STRAINED = "oedometric 12.5e3 axial_strain 0.0025 0.0699"


def table(*columns: tuple[str, object], head: str = "", units: str = "", tail: str = "") -> str:
    """Rows of columns, each a name with its numbers (or one number for all rows), below lines of remarks parted by |."""
    names, values = zip(*columns)
    rows = np.broadcast_arrays(*values)
    lines = [*head.split("|"), ",".join(names), units, *(",".join(f"{value:.4f}" for value in row) for row in zip(*rows)), tail]
    return "\n".join(line for line in lines if line) + "\n"


A, D, V = ("Axial strain (%)", STRAIN), ("Deviator stress (kPa)", Q), ("Volumetric strain (%)", VOLUME)
P, E = ("Vertical stress (kPa)", STRESS), ("Void ratio", VOID_RATIO)
ML = ("Volume change (ml)", VOLUME * 1.9635)
CELL, SIGMA_3 = ("Cell pressure (kPa)", 500), ("σ3 (kPa)", 100)


def headed(head: str) -> str:
    return table(A, D, V, head=head)


def stepped() -> str:
    """An oedometer read five times under each load."""
    before = np.concatenate([[0.72], VOID_RATIO[:-1]])
    ways = np.arange(1, 6) / 5
    return table(
        ("Vertical stress (kPa)", np.repeat(STRESS, 5)),
        ("Time (min)", np.tile(ways, 8)),
        ("Void ratio", (before[:, None] + (VOID_RATIO - before)[:, None] * ways).ravel()),
    )


TWICE = tuple((name, np.concatenate([values[:9], values[:12]])) for name, values in (A, D, V))
SLIP = ("Axial strain (%)", np.where(STRAIN == 3, 30, STRAIN))

JITTER = np.array([3, -5, 2, 4, -4, 1, -2, 5, -3, 0, 2, -1, 4, -5, 1]) / 5
"""As noise: between -1 and 1, without a trend."""
PULLED = -60 * STRAIN / (0.6 + STRAIN)
RATIO_PULLED = "stress_ratio 1 0.4231"


def precise(*columns: tuple[str, np.ndarray]) -> str:
    """As `table`, with every digit."""
    return "\n".join([",".join(name for name, _ in columns), *(",".join(map(repr, map(float, row))) for row in zip(*(values for _, values in columns)))]) + "\n"


# name: text, options beside --strain engineering, what is read (kind, pressure, observables with first and last), or words of what is refused or asked
# fmt: off
FILES = {
    "a change of volume in percent": (table(A, D, ("Volume change (%)", VOLUME)), AT_100, DRAINED),
    "a deformation in millimetres": (table(("Axialverformung [mm]", STRAIN * 1.4), D, V, head="Probenhöhe [mm]: 140"), AT_100, DRAINED),
    "a height that is given": (table(("Axialverformung [mm]", STRAIN), D, V), f"{AT_100} --sample-height 0.1", DRAINED),
    "a volume that is given": (table(A, D, ML), f"{AT_100} --sample-volume 196.35e-6", DRAINED),
    "a back pressure in German": (table(A, D, V, head="Zelldruck [kPa]: 500|Gegendruck [kPa]: 300"), "", "? back pressure"),
    "a coefficient of uniformity": (table(A, D, head="Cu = 1.6"), AT_100, "? drained from an undrained"),
    "small strains": (table(("Axial strain (%)", STRAIN / 30), D, ("Volumetric strain (%)", VOLUME / 30), ("σ3' (kPa)", 100)), "", "triaxial 100e3 stress_ratio 1 3.673"),
    "noise of a pore pressure": (table(A, ("σ1'/σ3'", 1 + Q / 100), ("Pore pressure (kPa)", 300 + 0.1 * JITTER)), AT_100, "? drained from an undrained"),
    "noise of a large pore pressure": (table(A, D, ("Pore pressure (kPa)", 300 + 2.5 * JITTER), ("σ3' (kPa)", 100 - 2.5 * JITTER)), "", "triaxial 99.93e3 stress_ratio 1 3.6865"),
    "a burette that stays": (table(A, D, ("Volume change (ml)", 0.01 * JITTER), head="Height,10,cm|Diameter,5,cm"), AT_100, "undrained 100e3 deviatoric_stress 0 267307.7"),
    "a stress against the strain": (table(A, ("Deviator stress (kPa)", -Q)), f"{AT_100} --kind triaxial", "? deviator stress is negative"),
    "an extension by q/p": (table(("Axial strain (%)", -STRAIN), ("q/p'", PULLED / (100 + PULLED / 3)), head="drained triaxial extension"), AT_100, f"triaxial 100e3 {RATIO_PULLED}"),
    "limits of the void ratio": (table(A, D, V, head="Maximum void ratio: 0.977|Minimum void ratio: 0.597"), AT_100, DRAINED),
    "a volume that dilates, with every digit": (precise(("Axial strain (%)", STRAIN), ("Deviator stress (kPa)", Q), ("Volumetric strain (%)", 0.3 * STRAIN * (STRAIN < 10) + 3.0 * (STRAIN >= 10) + 1e-5 * JITTER)), f"{AT_100} --kind triaxial", "? compression"),
    "microstrain without a unit": (table(("Axial strain", STRAIN * 1e4), D, V), AT_100, "? unit"),
    "small strains in percent without a unit": (table(("Axial strain", STRAIN / 40), ("Deviator stress (kPa)", Q[-1] * STRAIN / 15)), f"{AT_100} --kind triaxial", "? unit"),
    "a consolidation among chosen rows": (table(("Axial strain (%)", np.concatenate([np.zeros(5), STRAIN])), ("Deviator stress (kPa)", np.concatenate([np.zeros(5), Q])), ("σ3' (kPa)", np.concatenate([[20, 40, 60, 80, 95], np.full(15, 100)]))), "--kind triaxial --rows 2-21", "? consolidation"),
    "a displacement and its sample's height": (table(("Axial displacement (mm)", STRAIN), D, V, head="Sample height: 100 mm"), AT_100, DRAINED),
    "a displacement and no height": (table(("Axial displacement (mm)", STRAIN), D, V), AT_100, "? columns"),
    "heights before and after consolidation": (table(("Displacement (mm)", STRAIN * 0.98), D, V, head="Initial height: 100 mm|Height after consolidation: 98 mm"), AT_100, DRAINED),
    "a cap's height": (table(A, D, ML, head="Top cap height,2,cm|Cap diameter,5,cm|Sample height,10,cm|Sample diameter,5,cm"), AT_100, DRAINED),
    "two heights": (table(A, D, ML, head="Height,10,cm|Diameter,5,cm|Height,12,cm"), AT_100, "? more than one"),
    "an applied pressure": (table(("Applied Pressure (kPa)", STRESS), E, head="Consolidation test"), "", COMPRESSED),
    "settlements": (table(P, ("Settlement (mm)", SETTLED), head="Oedometer test|Initial height = 20 mm"), "", STRAINED),
    "settlements without a height": (table(P, ("Settlement (mm)", SETTLED), head="Oedometer test"), "", "? columns"),
    "a constant rate of strain": (table(("Axial strain (%)", SETTLED * 5), ("Total vertical stress (kPa)", STRESS * 1.075), ("Pore pressure (kPa)", STRESS * 0.075), E), "", COMPRESSED),
    "a total stress and an excess pressure": (table(("Axial strain (%)", SETTLED * 5), ("Total vertical stress (kPa)", STRESS * 1.075), ("Excess pore pressure (kPa)", STRESS * 0.075), E, head="CRS test"), "", "? columns"),
    "readings over time under each load": (stepped(), "--kind oedometric", COMPRESSED),
    "corrected and uncorrected": (table(A, ("Deviator stress uncorrected (kPa)", Q * 1.08), ("Deviator stress corrected (kPa)", Q), V), AT_100, "? can both be deviator stress"),
    "corrected, chosen": (table(A, ("Deviator stress uncorrected (kPa)", Q * 1.08), ("Deviator stress corrected (kPa)", Q), V), f"{AT_100} --column deviator_stress=3", DRAINED),
    "corrected alone": (table(A, ("Corrected deviator stress (kPa)", Q), V), AT_100, DRAINED),
    "local and external": (table(("External axial strain (%)", STRAIN), ("Local axial strain (%)", STRAIN * 0.9), D, V), AT_100, "? can both be axial strain"),
    "two curves of one name": (table(A, D, ("Axial strain (%)", STRAIN * 1.1), V), AT_100, "? can both be axial strain"),
    "one stress in two units": (table(A, D, ("Deviator stress (psi)", Q / 6.894757), V), AT_100, DRAINED),
    "q of MIT beside the difference": (table(A, ("q (kPa)", Q / 2), ("σ1-σ3 (kPa)", Q), V), AT_100, "? can both be deviator stress"),
    "q of MIT in a remark": (table(A, ("q (kPa)", Q / 2), V, head="q = (s1-s3)/2"), AT_100, DRAINED),
    "q of MIT in its name": (table(A, ("q = (σ1-σ3)/2 (kPa)", Q / 2), V), AT_100, DRAINED),
    "no pressure in a formula": (table(A, ("q = (σ1-σ3)/2 (kPa)", Q / 2), V), "", "? confining pressure"),
    "a cell pressure beside sigma 3": (table(A, CELL, SIGMA_3, D, V), "", DRAINED),
    "sigma 3 beside a cell pressure": (table(A, SIGMA_3, CELL, D, V), "", DRAINED),
    "a stress that is not known": (table(A, ("Stress (kPa)", Q + 100), V), AT_100, "? not known what 2"),
    "a friction angle": (table(A, ("Mobilised friction angle (deg)", Q / 10), V), AT_100, "? not known what 2"),
    "q over sigma 3": (table(A, ("q/σ3", Q / 100), V), AT_100, "? not known what 2"),
    "no stress, said": (table(A, ("q/σ3", Q / 100), V), f"{AT_100} --column volumetric_strain=3:%", "triaxial 100e3 volumetric_strain 0 -0.0133"),
    "two units": (table(A, D, V, units="%,MPa,%"), AT_100, "? in kPa by its header and in MPa"),
    "two units, one chosen": (table(A, D, V, units="%,MPa,%"), f"{AT_100} --column deviator_stress=2:kPa", DRAINED),
    "tests below one another": (table(*TWICE), AT_100, "? grows again"),
    "a slip of the strain": (table(SLIP, D, V), AT_100, "? grows again"),
    "zeros at the end": (table(A, D, V, tail="0,0,0\n0,0,0"), AT_100, DRAINED),
    "strains from before the shear": (table(A, D, ("Volumetric strain (%)", VOLUME + 1.2)), AT_100, "? count from before the shear"),
    "strains from before the shear, from its first row": (table(A, D, ("Volumetric strain (%)", VOLUME + 1.2)), f"{AT_100} --rows 2-16", f"triaxial 100e3 {RATIO} volumetric_strain 0 -0.0135"),
    "back press.": (headed("Cell pressure (kPa),400|Back press. (kPa),300"), "", "? speaks of a back pressure"),
    "BP": (headed("Cell pressure: 400 kPa|BP: 300 kPa"), "", "? speaks of a back pressure"),
    "u0": (headed("Cell pressure: 400 kPa|u0 = 300 kPa"), "", "? speaks of a back pressure"),
    "a column of cell pressure and u0": (table(A, ("Cell pressure (kPa)", 400), D, V, head="u0 = 300 kPa"), "", "? confining pressure"),
    "in Spanish": (headed("Presión de cámara: 400 kPa; contrapresión: 300 kPa"), "", "? speaks of a back pressure"),
    "the effective one is said too": (headed("Cell pressure = 400 kPa|Back pressure = 300 kPa|Effective confining pressure = 100 kPa"), "", DRAINED),
    "a preconsolidation": (headed("Preconsolidation pressure 800 kPa|Confining pressure 100 kPa"), "", DRAINED),
    "an apparatus": (headed("Max. cell pressure of the apparatus 1700 kPa|Confining pressure 100 kPa"), "", DRAINED),
    "a pressure with its symbol": (headed("Zelldruck σ3 = 100 kN/m²"), "", DRAINED),
    "two pressures": (headed("Confining pressure, first: 50 kPa|Confining pressure, second: 100 kPa"), "", "? 50000 Pa and 100000 Pa"),
    "constant p in words": (table(A, D, V, head="Constant mean effective stress|Confining pressure = 200 kPa"), "", "constant-mean-stress 200e3 deviatoric_stress 0 267308 volumetric_strain 0 -0.0133"),
    "a plane strain test": (table(A, ("σ'1 (kPa)", 100 + Q), ("σ'3 (kPa)", 100), V, head="Plane strain compression"), "", "? 'Plane strain'"),
    "a shear box": (table(("Shear strain (%)", STRAIN), ("Shear stress (kPa)", Q / 2), ("Normal stress (kPa)", 100), head="Simple shear test"), "", "? columns"),
    "p and a back pressure": (table(("p (kPa)", STRESS + 200), E, head="Isotropic compression, back pressure 200 kPa"), "", "? total_mean_stress"),
    "no lateral strain, and no test that is known": (table(("Axial strain (%)", np.linspace(0, 3, 15)), ("σ'v (kPa)", np.linspace(50, 400, 15)), ("σ'h (kPa)", np.linspace(22.5, 180, 15)), ("Volumetric strain (%)", np.linspace(0, 3, 15))), "", "? goes from 22500 to 180000 Pa"),
}
# fmt: on


def expectation(said: str) -> Expectation:
    kind, pressure, *figures = said.split()
    observables = {name: Figures(float(first), float(last), None, None, max(1e-4, 6e-3 * abs(float(last)))) for name, first, last in zip(*[iter(figures)] * 3)}
    return Expectation(kind, None, float(pressure), ("axial_stress",) if kind == "oedometric" else ("axial_strain", "axial_extension"), observables, {})


@pytest.mark.parametrize("name", FILES)
def test_it_is_read_right_or_asked(name: str, tmp_path: Path) -> None:
    text, options, said = FILES[name]
    file = tmp_path / "lab.csv"
    file.write_text(text, encoding="utf-8")
    void_ratio = VOID_RATIO[0] if "Void ratio" in text else 0.68
    expected = None if said.startswith("? ") else expectation(said)
    found = read(file, ["--strain", "engineering", *shlex.split(options)], packing(void_ratio, tmp_path), tmp_path / "calibration.toml", expected)
    if expected is not None:
        assert found.verdict == "RIGHT", f"{found.verdict}: {found.why}"
    else:
        assert found.verdict == "ASKED", f"{found.verdict}: {found.why}"
        assert re.search(re.escape(said.removeprefix("? ")), found.why), found.why


def test_a_logarithm_in_one_name_is_not_that_of_the_next(tmp_path: Path) -> None:
    """The strains that stand beside log time are not logarithmic."""
    file = tmp_path / "lab.csv"
    file.write_text(table(("log time", np.log10(1 + STRAIN)), A, D, V))
    found = read(file, AT_100.split(), packing(0.68, tmp_path), tmp_path / "calibration.toml", None)
    assert found.verdict == "ASKED" and "engineering or logarithmic" in found.why, found.why
