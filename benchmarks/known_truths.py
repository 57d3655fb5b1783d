"""Whether probabilities are right on the engine's own test: known truths, each one run on another packing than the calibration's.

    GRAINCAL_REFERENCE_DATA=... python benchmarks/known_truths.py --folder DIR [--rows DIR] [--truths 120] [--libraries 3] [--runs 600] [--by-the-paper 15]

Each truth is drawn from the paper's ranges, and run once on a packing of its own that is prepared like the paper's packing of 1,000 particles (drained triaxial compression at 0.5 MPa to 20 % of axial strain);
a truth whose run fails is drawn again. To its curve come errors as a laboratory would state them, of 0.02 in the stress ratio and 0.05 % in volumetric strain, alike along the curve over one of the lengths that the
error model holds possible. The calibration is on the paper's packing, by defaults, and is told these errors. So that each takes minutes, it begins with the runs of one of several libraries of `graincal explore`, the first
truths with the first; it goes on by its own rule. All are counted at their end, settled or not.

Were posteriors exact, the rank of each true parameter among 99 draws would be uniform, and so would that of the truth's log likelihood. Printed are how far from uniform the ranks are, and whether they stay within a band that
any of the six would leave by chance in one case of twenty, for all truths and for those of each library apart, and the same for posteriors shrunk to 0.8 of their deviation, which ought to be refused. Truths that share a
library share what is wrong with it: so the band for all truths, which takes them for independent, is too narrow, and it is the libraries' own bands that judge. For the same reason the part of intervals that hold the truth has an error from as many numbers as there are libraries. Last, how many intervals hold the truth had all covariances of the errors been half or twice as
large, and the truth's mean log density above the prior's.

With --by-the-paper the first truths are calibrated by the paper's method too, by runs of their own, and what its last weighted samples say is counted in the same way.
Everything is kept in DIR; the same command continues where it was interrupted. What each truth came to is a small file of --rows (DIR by default): with those alone it continues on another machine too.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rank_table import LEVELS, inside, show
from scipy.stats import binom, t

import graincal as gc
from graincal.campaign import Experiment, resume
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.run.running import begin_or_resume
from graincal.campaign.stored.provenance import provenance
from graincal.campaign.stored.store import Store, holds_campaign
from graincal.dem.siblings import siblings
from graincal.inference.likelihood.error_model import CORRELATION_LENGTHS
from graincal.inference.posterior.sensitivity import under_other_errors
from graincal.inference.sampling.ranks import rank

PRESSURE, STRAIN = 0.5e6, np.arange(0.0, 0.2001, 0.005)
DEVIATIONS = {"stress_ratio": 0.02, "volumetric_strain": 0.0005}
FIRST_SEED = 201
"""Of the packings of the truths: none of those that calibrations prepare."""
FACTORS = (1.0, 0.5, 2.0)
DRAWS, SHRUNK = 99, 0.8
_OTHER = "{}: it learnt from another library than {}; the same --truths and --libraries as before were expected, or another folder."
SPACE = gc.ParameterSpace.paper()
QUANTITIES = (*SPACE.names, "log likelihood")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--rows", type=Path, help="where what each truth came to is kept; --folder by default")
    parser.add_argument("--truths", type=int, default=120)
    parser.add_argument("--libraries", type=int, default=3)
    parser.add_argument("--runs", type=int, default=600, help="in each library")
    parser.add_argument("--by-the-paper", type=int, default=0, metavar="N", help="so many of the truths by the paper's method too")
    arguments = parser.parse_args()
    test = gc.TriaxialTest(gc.Packing.read(Path(os.environ["GRAINCAL_REFERENCE_DATA"]) / "packing_1000.csv"), PRESSURE)
    rows = []
    for number in range(arguments.truths):
        library = number * arguments.libraries // arguments.truths
        explored = partial(gc.explore, test, SPACE, to=STRAIN[-1], folder=arguments.folder / f"library-{library + 1}", runs=arguments.runs, seed=library + 1)
        row = of_truth(test, number, explored, arguments.folder, arguments.rows or arguments.folder)
        rows.append(row | {"library": library})
        print(
            f"truth {number}: {'settled' if row['settled'] else 'not settled'} after {row['evaluations']} evaluations, ε {row['error']:.2f} %, log density {row['gained']:+.1f}",
            flush=True,
        )
    report(rows, arguments.libraries)
    if arguments.by_the_paper:
        report_paper([of_truth_by_the_paper(test, number, arguments.folder) for number in range(arguments.by_the_paper)])


def of_truth(test: gc.TriaxialTest, number: int, explored: partial[Path], folder: Path, rows: Path) -> dict:
    """What the calibration of one truth says, kept as a row. explored: the library that it begins with."""
    kept, place, library = rows / f"{number:03d}.json", folder / f"{number:03d}", explored.keywords["folder"]
    if place.exists() and holds_campaign(place):
        refuse_another_library(place, library)
    if kept.exists():
        row = json.loads(kept.read_text())
        # Rows of before say nothing of it; their campaigns do.
        if row.get("learnt_from", library.name) != library.name:
            sys.exit(_OTHER.format(kept, library.name))
        return row

    def asked() -> Calibration:
        truth, curve = reference(test, number)
        return Calibration(SPACE, [Experiment("truth", test, curve)], seed=number, truth=dict(zip(SPACE.names, truth.tolist())))

    result = begin_or_resume(place, asked, [explored()])
    truth, posterior, rng = true_values(result), result.posterior, np.random.default_rng([number, 3])
    log_likelihood = lambda theta: result.emulation.log_likelihood(SPACE.to_unit(theta))  # noqa: E731
    quantities = lambda theta: np.column_stack([theta, log_likelihood(theta)])  # noqa: E731
    mean, known = posterior.mean(), quantities(truth[None])[0]
    shrunk = mean + SHRUNK * (posterior.samples - mean)
    row = {
        "learnt_from": library.name,
        "made_with": provenance(),
        "truth": truth.tolist(),
        "mean": mean.tolist(),
        "std": posterior.std().tolist(),
        "settled": bool(result.settled),
        "evaluations": int(result.evaluations),
        "error": float(result.answer.mean),
        "gained": float(known[-1] - result.log_evidence),
        "ranks": [rank(known, quantities(theta), posterior.weights, DRAWS, rng).tolist() for theta in (posterior.samples, shrunk)],
        "held": [[held(each, truth, level) for level in LEVELS] for each in under_factors(result)],
    }
    rows.mkdir(parents=True, exist_ok=True)
    kept.write_text(json.dumps(row) + "\n")
    return row


def refuse_another_library(place: Path, library: Path) -> None:
    """Stop where a calibration learnt from another library than the one that its truth has now: the numbers of truths and of libraries say which has which."""
    with closing(Store.open(place)) as store:
        (source,) = store.description["known"]["sources"]
    if not re.search(rf"(^|[/ ]){re.escape(library.name)}\b", source):
        sys.exit(_OTHER.format(place, library.name))


def of_truth_by_the_paper(test: gc.TriaxialTest, number: int, folder: Path) -> dict:
    """What the paper's method says of one truth."""
    place = folder / f"paper-{number:03d}"
    if place.exists() and holds_campaign(place):
        result = resume(place)
    else:
        truth, curve = reference(test, number)
        stop = gc.Stop(s=0.01, gl_error_increment=False, error=False, error_increment=False, max_iterations=20)
        result = gc.calibrate(
            test, curve, SPACE, method="iterative-bayesian", seed=number, alpha=10, stop=stop, folder=place, truth=dict(zip(SPACE.names, truth.tolist()))
        )
    truth, posterior = true_values(result), result.posterior
    row = {
        "evaluations": int(result.evaluations),
        "ranks": rank(truth, posterior.samples, posterior.weights, DRAWS, np.random.default_rng([number, 3])).tolist(),
    }
    print(f"truth {number} by the paper's method: {row['evaluations']} evaluations", flush=True)
    return row


def true_values(result: gc.Result) -> NDArray[np.float64]:
    return np.array([result.truth[name] for name in SPACE.names])


def reference(test: gc.TriaxialTest, number: int) -> tuple[NDArray[np.float64], gc.Reference]:
    """The truth (n,) of a number, and its run with errors."""
    (packing,) = siblings(test.packing, 1, first_seed=FIRST_SEED + number)
    rng = np.random.default_rng(number)
    while True:
        truth = SPACE.from_unit(rng.random(SPACE.size))
        response = replace(test, packing=packing, packings=()).simulate([truth], at=STRAIN)[0]
        if isinstance(response, gc.Response):
            break
    length = rng.choice(CORRELATION_LENGTHS)
    factor = np.linalg.cholesky(np.exp(-np.abs(STRAIN[:, None] - STRAIN) / STRAIN[-1] / length))
    values = {name: response.values[name] + deviation * (factor @ rng.standard_normal(len(STRAIN))) for name, deviation in DEVIATIONS.items()}
    return truth, gc.Reference(STRAIN, values, measurement_errors=DEVIATIONS, simulated=True)


def under_factors(result: gc.Result) -> list[gc.Posterior]:
    """The posterior, had the covariances of the errors been so many times as large."""
    known = result.knowledge
    errors = [tuple(replace(each, covariances=factor * each.covariances) for each in known.errors) for factor in FACTORS[1:]]
    rng = np.random.default_rng(0)
    return [result.posterior, *(under_other_errors(result.emulation, result.space, known.kept, known.scatters, each, rng) for each in errors)]


def held(posterior: gc.Posterior, truth: NDArray[np.float64], level: float) -> int:
    """How many parameters' intervals hold the truth."""
    low, high = posterior.interval(level)
    return int(np.sum((low <= truth) & (truth <= high)))


def report(rows: list[dict], libraries: int) -> None:
    ranks = np.array([row["ranks"] for row in rows])  # (truths, 2, quantities)
    of = np.array([row["library"] for row in rows])
    print(
        f"\n{len(rows)} truths, {sum(row['settled'] for row in rows)} of them settled; {np.median([row['evaluations'] for row in rows]):.0f} evaluations (median)"
    )
    # The first two take truths for independent, and those of one library are not.
    show("all truths as if independent, posterior as reported", dict(zip(QUANTITIES, ranks[:, 0].T)), DRAWS, QUANTITIES)
    show(f"all truths as if independent, posterior shrunk to {SHRUNK:g} of its deviation", dict(zip(QUANTITIES, ranks[:, 1].T)), DRAWS, QUANTITIES)
    uniform = [
        show(f"truths of library {library + 1}", dict(zip(QUANTITIES, ranks[of == library, 0].T)), DRAWS, QUANTITIES)
        for library in range(libraries if libraries > 1 else 0)
    ]
    if uniform:
        print(f"\nlibraries whose truths have uniform ranks, as far as one can tell: {sum(uniform)} of {len(uniform)}")
    for level in LEVELS:
        parts = [np.mean(inside(ranks[of == library, 0, : SPACE.size], DRAWS, level)) for library in range(libraries)]
        print(f"\nintervals of {level:.0%} that hold the truth, by library: {', '.join(f'{part:.1%}' for part in parts)}{interval(parts)}")
    total = len(rows) * SPACE.size
    for number, factor in enumerate(FACTORS):
        counts = np.sum([row["held"][number] for row in rows], axis=0)
        bands = [
            f"{count} of {total} of {level:.0%} ({binom.ppf(0.025, total, level):.0f} to {binom.ppf(0.975, total, level):.0f})"
            for count, level in zip(counts, LEVELS)
        ]
        print(f"covariances times {factor:g}: {', '.join(bands)}")
    print(f"the truth's log density is {np.mean([row['gained'] for row in rows]):.2f} above the prior's on the mean")


def interval(parts: list[float]) -> str:
    """The mean over libraries and its interval of 95 %, by Student's t."""
    if len(parts) < 2:
        return ""
    wide = t.ppf(0.975, len(parts) - 1) * np.std(parts, ddof=1) / np.sqrt(len(parts))
    return f"; {np.mean(parts):.1%} ± {wide:.1%}, of {len(parts)} libraries"


def report_paper(rows: list[dict]) -> None:
    ranks = np.array([row["ranks"] for row in rows])
    show(f"{len(rows)} truths by the paper's method, its last weighted samples", dict(zip(SPACE.names, ranks.T)), DRAWS, SPACE.names)


if __name__ == "__main__":
    main()
