"""A whole calibration from each kind of laboratory test: from the laboratory's file to the finished campaign, by the command line alone.

The sand is a packing of other grains, sheared or compressed by the engine at TRUTH, and written as a laboratory writes it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

import graincal as gc
from graincal.cli import app
from graincal.dem.preparation import prepare
from graincal.positions import POSITION, positions

pytestmark = pytest.mark.usefixtures("fewer_draws")

PRESSURE = 1e5
TRUTH = {"log_E": 8.2, "phi": 30.0}
SCATTER = 25
"""Percent: packings of so few grains differ much, and none of them is the sand."""
FIXED = {"nu": 0.2, "beta_m": 0.1, "eta_m": 0.3}
PARAMETERS = '[parameters]\nlog_E = { range = [7.7, 8.7], unit = "log10 Pa" }\nphi   = { range = [15, 45], unit = "deg" }\n'
STRAINS = np.linspace(0, 0.04, 11)
LOADED = np.array([25.0, 50.0, 100.0, 200.0, 100.0, 50.0, 100.0, 200.0, 400.0])
"""kPa: loaded, unloaded and reloaded."""
TURNS = (2e5, 5e4)
PAPER = "iterative-bayesian"


@dataclass(frozen=True)
class Told:
    """A file and what a person tells init of it; then the kind, the control, the turns and the observables, with their errors, that the calibration file is to have.

    method: what it is calibrated by.
    """

    name: str
    options: str
    kind: str
    control: str
    observables: Mapping[str, str]
    turns: tuple[float, ...] = ()
    method: str = PAPER


def engineering(strain: NDArray[np.float64]) -> NDArray[np.float64]:
    """In percent, of logarithmic strains (T,) as fractions."""
    return 100 * (1 - np.exp(-strain))


def rows(*columns: NDArray[np.float64], decimals: tuple[int, ...], between: str = "\t", comma: bool = False) -> str:
    lines = (between.join(f"{value:.{places}f}" for value, places in zip(line, decimals)) for line in zip(*columns))
    text = "\n".join(lines) + "\n"
    return text.replace(".", ",") if comma else text


def drained(sand: gc.Packing) -> str:
    seen = response(gc.TriaxialTest(sand, PRESSURE, fixed=FIXED), STRAINS)
    head = "Triaxialversuch CD;;\nZelldruck [kPa];100;\nAxialdehnung;Deviatorspannung;Volumendehnung\n%;kPa;%\n"
    return head + rows(
        engineering(STRAINS), (seen["stress_ratio"] - 1) * PRESSURE / 1e3, engineering(seen["volumetric_strain"]), decimals=(4, 2, 5), between=";", comma=True
    )


def undrained(sand: gc.Packing) -> str:
    seen = response(gc.UndrainedTest(sand, PRESSURE, fixed=FIXED), STRAINS)
    head = "# CU test, effective confining pressure 100 kPa, engineering strains\nAxial strain\tDeviator stress\tExcess pore pressure\n%\tkPa\tkPa\n"
    return head + rows(engineering(STRAINS), seen["deviatoric_stress"] / 1e3, seen["excess_pore_pressure"] / 1e3, decimals=(4, 2, 2))


def extension(sand: gc.Packing) -> str:
    seen = response(gc.TriaxialTest(sand, PRESSURE, control="axial_extension", fixed=FIXED), STRAINS)
    lateral = np.full(len(STRAINS), PRESSURE / 1e3)
    head = "ea (%),ev (%),s1' (kPa),s3' (kPa)\n"
    return head + rows(
        engineering(-STRAINS), engineering(seen["volumetric_strain"]), seen["stress_ratio"] * lateral, lateral, decimals=(4, 5, 2, 2), between=","
    )


def undrained_extension(sand: gc.Packing) -> str:
    seen = response(gc.UndrainedTest(sand, PRESSURE, control="axial_extension", fixed=FIXED), STRAINS)
    head = "# Triaxial extension, undrained, logarithmic strains\nAxial strain [-] q [kPa] u [kPa] Cell pressure [kPa]\n"
    head = head.replace("] ", "]\t")
    return head + rows(-STRAINS, seen["deviatoric_stress"] / 1e3, 600 + seen["excess_pore_pressure"] / 1e3, np.full(len(STRAINS), 700.0), decimals=(6, 2, 2, 1))


def constant_mean(sand: gc.Packing) -> str:
    seen = response(gc.ConstantMeanStressTest(sand, PRESSURE, fixed=FIXED), STRAINS)
    ratio = seen["stress_ratio"]
    lateral = 3 * PRESSURE / 1e3 / (ratio + 2)
    head = "eps_a [%];eps_v [%];sigma_1' [MPa];sigma_3' [MPa]\n"
    return head + rows(100 * STRAINS, 100 * seen["volumetric_strain"], 1e-3 * ratio * lateral, 1e-3 * lateral, decimals=(4, 5, 6, 6), between=";")


def cycle(kind: type, sand: gc.Packing) -> NDArray[np.float64]:
    """Void ratios (T,) at the stresses of LOADED."""
    first = 1e3 * LOADED[0]
    return response(kind(sand, first, control=POSITION, turns=TURNS, fixed=FIXED), positions(1e3 * LOADED, first))["void_ratio"]


def oedometer(sand: gc.Packing) -> str:
    return "Oedometer test\nVertical stress  Void ratio\nkPa  -\n" + rows(LOADED, cycle(gc.OedometricTest, sand), decimals=(1, 4), between="  ")


def isotropic(sand: gc.Packing) -> str:
    return "Isotropic compression;\np' [kPa];Void ratio\n" + rows(LOADED, cycle(gc.IsotropicTest, sand), decimals=(1, 4), between=";")


def consolidation(sand: gc.Packing) -> str:
    head = '"GROUP","PROJ"\n"HEADING","PROJ_ID"\n"UNIT",""\n"TYPE","ID"\n"DATA","P1"\n\n"GROUP","CONS"\n"HEADING","LOCA_ID","CONS_INCN","CONS_INCF","CONS_INCE"\n"UNIT","","","kPa",""\n"TYPE","ID","X","0DP","4DP"\n'
    found = cycle(gc.OedometricTest, sand)
    return head + "".join(f'"DATA","BH1","{number}","{stress:.0f}","{ratio:.4f}"\n' for number, (stress, ratio) in enumerate(zip(LOADED, found), start=1))


def response(test: gc.models.StressPathTest, at: NDArray[np.float64]) -> Mapping[str, NDArray[np.float64]]:
    (found,) = test.simulate([list(TRUTH.values())], at=at, threads=1)
    return found.values


VOID_RATIO = {"void_ratio": "measurement_error = 0.001"}
RATIO = "relative_error = 0.01"
# fmt: off
FILES = {
    drained: Told("cd.csv", "--strain engineering", "triaxial", "axial_strain", {"stress_ratio": RATIO, "volumetric_strain": r"measurement_error = 0\.0001"}, method="posterior"),
    undrained: Told("cu.txt", "", "undrained", "axial_strain", {"deviatoric_stress": r"measurement_error = \d000", "excess_pore_pressure": r"measurement_error = \d000"}),
    extension: Told("extension.csv", "--strain engineering --compression volumetric_strain=positive", "triaxial", "axial_extension", {"stress_ratio": RATIO, "volumetric_strain": r"measurement_error = 0\.0002"}),
    undrained_extension: Told("cue.dat", "", "undrained", "axial_extension", {"deviatoric_stress": r"measurement_error = \d000", "excess_pore_pressure": r"measurement_error = \d000"}),
    constant_mean: Told("p.csv", "--strain logarithmic --compression volumetric_strain=positive", "constant-mean-stress", "axial_strain", {"stress_ratio": RATIO, "volumetric_strain": r"measurement_error = 0\.000\d"}),
    oedometer: Told("oedometer.txt", "", "oedometric", POSITION, VOID_RATIO, TURNS, method="posterior"),
    isotropic: Told("isotropic.csv", "", "isotropic", POSITION, VOID_RATIO, TURNS),
    consolidation: Told("consolidation.ags", "", "oedometric", POSITION, VOID_RATIO, TURNS),
}
# fmt: on


@pytest.fixture(scope="module")
def grains(tmp_path_factory):
    """The packing to calibrate with, and the sand: as many other grains at the same void ratio."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GRAINCAL_CACHE", str(tmp_path_factory.mktemp("packings")))
        yield prepare(180, 0.68, seed=1), prepare(180, 0.68, seed=2)


def run(*arguments: object) -> str:
    """What a command prints, which must end well."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, f"{result.output}{result.stderr}{result.exception!r}"
    return result.stdout


def shortened(text: str, method: str) -> str:
    """The calibration file with two unknowns, to end after few evaluations."""
    fixed = ", ".join(f"{name} = {value}" for name, value in FIXED.items())
    text = re.sub(r"\[parameters\].*?\n\n", lambda _: PARAMETERS + "\n", text, flags=re.S)
    text = text.replace("[experiment.model]", f"[experiment.model]\nfixed = {{ {fixed} }}")
    options = "packing_scatter = false\nfirst_batch = 12\nbatch = 4" if method == "posterior" else "alpha = 3"
    stop = "max_evaluations = 16" if method == "posterior" else "max_iterations = 1"
    text = text.replace('method = "posterior"', f'method = "{method}"\n{options}')
    return text.replace("[stop]", f"[stop]\n{stop}").replace('workers = "all"', "workers = 1")


@pytest.mark.parametrize("write", FILES, ids=lambda write: write.__name__)
def test_a_file_becomes_an_answer(write, grains: tuple[gc.Packing, gc.Packing], tmp_path: Path) -> None:
    told = FILES[write]
    own, sand = grains
    own.write(tmp_path / "packing.csv")
    laboratory, file, folder = tmp_path / told.name, tmp_path / "c.toml", tmp_path / "campaign"
    laboratory.write_text(write(sand), encoding="utf-8")
    run("init", laboratory, "--packing", tmp_path / "packing.csv", "-o", file, *told.options.split())
    proposed = file.read_text()
    for name, error in told.observables.items():
        assert re.search(rf"\b{name} = {{ {error} }}", proposed), proposed
    file.write_text(shortened(proposed, told.method))
    (experiment,) = json.loads(run("check", file, "--json"))["experiments"]
    assert (experiment["kind"], experiment["control"], set(experiment["observables"]) - {"stress_ratio"}) == (
        told.kind,
        told.control,
        set(told.observables) - {"stress_ratio"},
    )
    assert experiment["confining_pressure"] == pytest.approx(1e3 * LOADED[0] if told.turns else PRESSURE, rel=1e-4)
    run("calibrate", file, "-o", folder, "--quiet")
    found = json.loads(run("status", folder, "--json"))
    assert found["state"] == "finished" and found["failures"] == 0
    answer = found["answer"] if told.method == "posterior" else found["most_probable"]
    assert answer["theta"].keys() == TRUTH.keys() and found["best"]["error"] < SCATTER
    assert answer["mean" if told.method == "posterior" else "error"] is not None
    said = run("predict", folder, "--samples", "2", "--against", file, "-o", tmp_path / "band.csv")
    assert "calibrated against this test" in said and "measurement errors included, holds" in said
    band = np.genfromtxt(tmp_path / "band.csv", delimiter=",", names=True)
    assert len(band) == experiment["states"] and told.control in band.dtype.names
    if told.method == PAPER:
        # That of a posterior, which takes seconds, was written by calibrate.
        run("report", folder)
    assert "<svg" in (folder / "report.html").read_text()
