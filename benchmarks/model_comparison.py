"""Which contact law explains a test, and which predicts others: campaigns of three models, compared by evidence and by tests that were held out.

    python benchmarks/model_comparison.py --packing packing_1000.csv [--made-by linear hertz-mindlin] [--models linear hertz-mindlin ...] [-o folder]

A reference is one run of the engine at known parameters by one of the laws: drained to 20 % of axial strain at 0.5 MPa, on the calibration's own packing at another
density scaling, and taken as a laboratory's: with errors of 1 % of the peaks and nothing said of its own scatter. Linear springs with rolling resistance, the same without it, and Hertz-Mindlin contacts with it are calibrated against it. Each predicts what the same
grains do at 0.2 and at 1 MPa by thirty runs at parameters drawn from its posterior. Campaigns are kept in the folder, and one that is there is gone on with.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.campaign.found.comparison import compare
from graincal.campaign.stored.store import holds_campaign
from graincal.execution import available_cores

STRAIN = np.arange(0.0, 0.2001, 0.004)
CALIBRATED, HELD_OUT = 0.5e6, (0.2e6, 1e6)
LINEAR = gc.ParameterSpace.paper()
RANGES = {name: (low, high) for name, low, high in zip(LINEAR.names, LINEAR.low, LINEAR.high)}
UNITS = dict(zip(LINEAR.names, LINEAR.units))
# Young's moduli, as overlaps go with its power of 2/3, and Poisson's ratios below that law's bound.
HERTZ = gc.ParameterSpace(RANGES | {"log_E": (9, 12), "nu": (0, 0.49)}, units=UNITS)
WITHOUT_ROLLING = gc.ParameterSpace({name: RANGES[name] for name in ("log_E", "nu", "phi")}, units={name: UNITS[name] for name in ("log_E", "phi")})
MODELS = {
    "linear": (LINEAR, {}),
    "linear-without-rolling": (WITHOUT_ROLLING, {"fixed": {"beta_m": 0.0, "eta_m": 0.0}}),
    "hertz-mindlin": (HERTZ, {"law": "hertz-mindlin"}),
}
TRUTHS = {"linear": (8.72, 0.227, 28.1, 0.079, 0.569), "hertz-mindlin": (10.3, 0.2, 28.1, 0.079, 0.569)}

# What a laboratory's curves may be off by: shares of their peaks.
READING = 0.01
SAMPLES = 30


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packing", required=True)
    parser.add_argument("--made-by", nargs="*", default=list(TRUTHS), choices=list(TRUTHS))
    parser.add_argument("--models", nargs="*", default=list(MODELS), choices=list(MODELS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=available_cores())
    parser.add_argument("-o", "--output", type=Path, default=Path("model_comparison"))
    arguments = parser.parse_args()
    packing = gc.Packing.read(arguments.packing)
    for law in arguments.made_by:
        references = {pressure: made(packing, law, pressure) for pressure in (CALIBRATED, *HELD_OUT)}
        results = {}
        for model in arguments.models:
            folder = arguments.output / f"{Path(arguments.packing).stem}-{arguments.seed}" / f"{law}-by-{model}"
            results[model] = calibrated(packing, model, references[CALIBRATED], arguments.seed, arguments.threads, folder)
        print_table(law, packing, results, references, arguments.threads)


def made(packing: gc.Packing, law: str, pressure: float) -> gc.Reference:
    """A test on grains of known parameters."""
    test = gc.TriaxialTest(packing, pressure, density_scaling=990.0, law=law)
    (response,) = test.simulate(np.array(TRUTHS[law]), at=STRAIN, threads=1)
    curves = {name: response.values[name] for name in ("stress_ratio", "volumetric_strain")}
    errors = {name: READING * float(np.abs(values).max()) for name, values in curves.items()}
    return gc.Reference(STRAIN, curves, measurement_errors=errors)


def test_of(packing: gc.Packing, model: str, pressure: float) -> gc.TriaxialTest:
    return gc.TriaxialTest(packing, pressure, **MODELS[model][1])


def calibrated(packing: gc.Packing, model: str, reference: gc.Reference, seed: int, threads: int, folder: Path) -> gc.Result:
    if holds_campaign(folder):
        return gc.resume(folder, workers=threads)
    experiment = gc.Experiment("0.5 MPa", test_of(packing, model, CALIBRATED), reference)
    return gc.calibrate([experiment], space=MODELS[model][0], seed=seed, workers=threads, folder=folder)


def print_table(law: str, packing: gc.Packing, results: dict[str, gc.Result], references: dict[float, gc.Reference], threads: int) -> None:
    scores = {pressure: {} for pressure in HELD_OUT}
    for pressure in HELD_OUT:
        for model, result in results.items():
            prediction = gc.predict(result, test_of(packing, model, pressure), STRAIN, samples=SAMPLES, workers=threads)
            scores[pressure][model] = prediction.against(references[pressure])
            print(f"{model}, {pressure / 1e6:g} MPa: {len(prediction.failures)} of {SAMPLES} runs failed", flush=True)
    print(
        f"\nmade by {law}\n{'model':22}{'evaluations':>12}{'error %':>9}{'log evidence':>20}"
        + "".join(f"{f'{pressure / 1e6:g} MPa: log score':>22}{'error %':>9}{'in the band':>14}" for pressure in HELD_OUT)
    )
    for each in compare(results):
        result = results[each.name]
        line = f"{each.name:22}{result.evaluations:>12}{result.answer.mean:>9.2f}{f'{each.log_evidence:.1f} ± {each.log_evidence_std:.1f}':>20}"
        for pressure in HELD_OUT:
            score = scores[pressure][each.name]
            line += f"{score.log_score:>22.3f}{score.error:>9.2f}" + f"{' '.join(f'{share:.0%}' for share in score.coverage.values()):>14}"
        print(line, flush=True)


if __name__ == "__main__":
    main()
