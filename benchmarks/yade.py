"""YADE as a model: how far its curves are from the engine's, and how many of its evaluations a first look by the engine saves.

    python benchmarks/yade.py agreement [--packing FILE] [--axial-strain 0.1]
    python benchmarks/yade.py first-look [--packing FILE] [--seeds 1 2] [--evaluations 60]

Both need an installed `yade`. The packing is the embedded one of 500 particles where none is named. Agreement: the drained triaxial test at 0.5 MPa, at a middle, a stiff and a soft set of parameters, three runs of each
program whose densities are 0.1 % apart; means of three are compared by the paper's Eq. 5, in percent. First look: a curve of YADE at known parameters is calibrated by YADE, with three parameters, from their whole ranges and after a first look
by graincal's engine on the same packing; counted are YADE's evaluations until the posterior has settled, and until one is within 2 % of the curve.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import graincal as gc
from graincal import demo
from graincal.campaign import begin
from graincal.campaign.file.config import read_calibration
from graincal.models.rests import REST_EVERY, strains_at_rest
from graincal.models.yade.model import PARAMETERS, triaxial

CASES = {"middle": (8.72, 0.227, 28.1, 0.079, 0.569), "stiff": (10.0, 0.3, 20.0, 0.02, 0.2), "soft": (7.6, 0.2, 45.0, 0.3, 0.6)}
SCALINGS = (999, 1000, 1001)
COMPARED = ("stress_ratio", "volumetric_strain")
PRESSURE = 0.5e6
TRUTH = {"log_E": 8.72, "phi": 28.1, "eta_m": 0.569}
NEAR = 2.0
"""Percent: an evaluation that is as near as this to the curve is as good as another run at the truth."""

FILE = """
[parameters]
log_E = { range = [7.5, 9.5], unit = "log10 Pa" }
phi   = { range = [10, 50], unit = "deg" }
eta_m = { range = [0, 1] }

[[experiment]]
name        = "drained, 500 kPa"
reference   = { file = "reference.csv", strain = "logarithmic", simulated = true }
observables = { stress_ratio = { relative_error = 0.01 }, volumetric_strain = { measurement_error = 0.0003 } }
model       = { kind = "yade", packing = "PACKING", confining_pressure = 0.5e6, fixed = { nu = 0.227, beta_m = 0.079 } }

[filter]
packing_scatter = false

[stop]
max_evaluations = EVALUATIONS
"""
LOOK = '\n[first_look]\nmodel = { kind = "triaxial" }\n'


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["agreement", "first-look"])
    parser.add_argument("--packing", type=Path, default=Path(demo.__file__).with_name("packing_500.csv"))
    parser.add_argument("--axial-strain", type=float, help="of the last state; 0.1 for the agreement and 0.05 for the first look, where left out")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--evaluations", type=int, default=60, help="by YADE at the most")
    arguments = parser.parse_args()
    if arguments.what == "agreement":
        agreement(arguments.packing, arguments.axial_strain or 0.1)
    else:
        first_look(arguments.packing, arguments.axial_strain or 0.05, arguments.seeds, arguments.evaluations)


def agreement(packing: Path, last: float) -> None:
    strains = strains_at_rest(np.array([0.0, last]), REST_EVERY)
    print(f"{packing.name}, to {100 * last:g} % of axial strain; errors in percent: ε (stress ratio, volumetric strain)")
    for case, theta in CASES.items():
        yades = [values_of(triaxial(packing, PRESSURE, scaling), theta, strains) for scaling in SCALINGS]
        print(
            f"{case}: {', '.join(f'{name} {value:g}' for name, value in zip(PARAMETERS, theta))}\n  between YADE's runs                    {between(yades)}",
            flush=True,
        )
        for accuracy in ("standard", "reference"):
            ours = [
                values_of(gc.TriaxialTest(gc.Packing.read(packing), PRESSURE, density_scaling=scaling, accuracy=accuracy), theta, strains)
                for scaling in SCALINGS
            ]
            print(f"  between the engine's, {accuracy:16} {between(ours)}\n  means of three, {accuracy:22} {said(apart(mean(yades), mean(ours)))}", flush=True)


def values_of(model: gc.CommandModel | gc.TriaxialTest, theta: tuple[float, ...], strains: np.ndarray) -> dict[str, np.ndarray]:
    outcome = dict(model.evaluate(gc.Samples(np.arange(1), np.array([theta]), PARAMETERS), strains))[0]
    if not isinstance(outcome, gc.Response):
        raise SystemExit(f"A run gave no curve to compare: {outcome}")
    return {name: outcome.values[name] for name in COMPARED}


def mean(curves: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return {name: np.mean([curve[name] for curve in curves], axis=0) for name in COMPARED}


def apart(reference: dict[str, np.ndarray], curve: dict[str, np.ndarray]) -> np.ndarray:
    """The paper's Eq. 5, percent, of each quantity."""
    return np.array([100 * np.abs(reference[name] - curve[name]).sum() / np.abs(reference[name]).sum() for name in COMPARED])


def between(curves: list[dict[str, np.ndarray]]) -> str:
    return said(np.mean([apart(one, other) for one in curves for other in curves if one is not other], axis=0))


def said(errors: np.ndarray) -> str:
    return f"{errors.mean():5.2f} ({', '.join(f'{error:.2f}' for error in errors)})"


def first_look(packing: Path, last: float, seeds: list[int], evaluations: int) -> None:
    print(
        f"{packing.name}, to {100 * last:g} % of axial strain; {', '.join(f'{name} {value:g}' for name, value in TRUTH.items())}; at most {evaluations} evaluations by YADE"
    )
    print(f"{'':24}{'seed':>5}{'settled after':>15}{f'within {NEAR:g} %':>13}{'answer ε':>10}{'minutes':>9}  mean ± sd of {', '.join(TRUTH)}")
    with tempfile.TemporaryDirectory() as folder:
        reference(Path(folder), packing, last)
        for seed in seeds:
            for name, look in (("from the whole ranges", ""), ("after a first look", LOOK)):
                calibrate(Path(folder), packing, name, look, seed, evaluations)


def reference(folder: Path, packing: Path, last: float) -> None:
    """The curve of YADE at the truth, with other roundings than those of the calibrated runs."""
    theta = [{"nu": 0.227, "beta_m": 0.079, **TRUTH}[name] for name in PARAMETERS]
    strains = strains_at_rest(np.array([0.0, last]), REST_EVERY)
    values = values_of(triaxial(packing, PRESSURE, 1000), tuple(theta), strains)
    rows = zip(strains, *values.values())
    (folder / "reference.csv").write_text(
        "\n".join([",".join(("axial_strain", *COMPARED)), *(",".join(f"{value:.8g}" for value in row) for row in rows)]) + "\n"
    )


def calibrate(folder: Path, packing: Path, name: str, look: str, seed: int, evaluations: int) -> None:
    file = folder / "calibration.toml"
    file.write_text(FILE.replace("PACKING", str(packing.resolve())).replace("EVALUATIONS", str(evaluations)) + look)
    start = time.monotonic()
    result = begin(replace(read_calibration(file), seed=seed, workers=2), folder / f"{name} {seed}")
    minutes = (time.monotonic() - start) / 60
    near = np.flatnonzero(result.errors <= NEAR)
    settled = str(result.evaluations) if result.settled else f"not in {result.evaluations}"
    posterior = result.posterior
    found = ", ".join(f"{value:.3g} ± {sd:.2g}" for value, sd in zip(posterior.mean(), posterior.std()))
    print(f"{name:24}{seed:>5}{settled:>15}{near[0] + 1 if near.size else '-':>13}{result.answer.mean:>10.2f}{minutes:>9.1f}  {found}", flush=True)


if __name__ == "__main__":
    main()
