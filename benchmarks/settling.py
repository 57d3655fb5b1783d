"""Whether a posterior that is said to have settled is right, and whether it settles at all: on closed forms whose runs scatter as those of the engine do.

    python benchmarks/settling.py --results FILE [--seeds N] [--problems NAME ...] [--workers N]

The three problems of problems.py, against a reference with independent errors of 2 % of the peak, which the method is told. Each run has a smooth error of its own beside: half a percent of the peak
at the end of the curve, alike over a third of it, and a twentieth of that from state to state (runs of the engine at one Theta are 0.4 to 0.5 % of the peak apart). Calibrations are at their defaults,
but for a discrepancy that these models do not have, and for a limit of 400 evaluations. Printed are, for each problem: the median of the evaluations at which it settled, how many had not by five times
the median, and how many had settled with a mean more than half a standard deviation from the exact one or with a standard deviation off by more than a factor of 1.5. Rows are appended to FILE as
calibrations end, and those it holds are not run again.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np
from exact import exact_moments
from kept_rows import append_row, read_rows
from numpy.typing import NDArray
from problems import PROBLEMS, SPACE, STRAIN, Problem
from threadpoolctl import threadpool_limits

from graincal.inference import PosteriorFilter, Stop

NOISE = 0.02
SCATTER, ALIKE, ROUGH = 0.005, 1 / 3, 0.05
INDEPENDENT = 1e-3
MOST = 400
MEAN_OFF, FACTOR = 0.5, 1.5
FIELDS = ("problem", "seed", "evaluations", "settled", "mean_off", "factor", "doubt", "confirmed")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--problems", nargs="+", default=list(PROBLEMS), choices=list(PROBLEMS))
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    known = {(row["problem"], int(row["seed"])) for row in read_rows(arguments.results)}
    wanted = [(name, seed) for seed in range(arguments.seeds) for name in arguments.problems if (name, seed) not in known]
    with ProcessPoolExecutor(arguments.workers) as pool:
        for done in as_completed([pool.submit(calibrate, *each) for each in wanted]):
            append_row(arguments.results, done.result(), FIELDS)
    for name in arguments.problems:
        show(name, [row for row in read_rows(arguments.results) if row["problem"] == name and int(row["seed"]) < arguments.seeds])


def calibrate(name: str, seed: int) -> dict[str, str]:
    """One calibration, as a row of the results."""
    problem = PROBLEMS[name]
    with threadpool_limits(1):
        stop = Stop(max_evaluations=MOST)
        filter = PosteriorFilter(SPACE, problem.reference(seed, NOISE), correlation_length=INDEPENDENT, discrepancy=False, stop=stop, seed=seed)
        while not filter.finished:
            samples = filter.ask()
            filter.tell(samples, scattered(problem, samples.theta, np.random.default_rng([seed, 2, int(samples.ids[0])])))
        mean, std = exact_moments(name, seed, NOISE)
    off = np.abs(filter.posterior.mean() - mean) / std
    factor = np.exp(np.abs(np.log(filter.posterior.std() / std)))
    settled = filter.stopped_by == "posterior_shift"
    values = (name, seed, len(filter.evaluations), settled, f"{off.max():.3f}", f"{factor.max():.3f}", f"{filter.doubt.most:.3f}", f"{filter.confirmed:.3f}")
    return dict(zip(FIELDS, map(str, values)))


def scattered(problem: Problem, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Curves (N, T, J), each with an error of its own."""
    curves = problem.curves(theta)
    apart = (STRAIN[:, None] - STRAIN) / (ALIKE * np.ptp(STRAIN))
    smooth = np.linalg.cholesky(np.exp(-0.5 * apart**2) + 1e-9 * np.eye(len(STRAIN)))
    growing = SCATTER * STRAIN[:, None] / STRAIN[-1]
    errors = growing * (smooth @ rng.standard_normal(curves.shape) + ROUGH * rng.standard_normal(curves.shape))
    return curves + errors * np.abs(curves).max(axis=(0, 1))


def show(name: str, rows: list[dict[str, str]]) -> None:
    """One problem in one line."""
    settled = [row for row in rows if row["settled"] == "True"]
    count = np.array([int(row["evaluations"]) for row in settled])
    median = float(np.median(count)) if settled else np.nan
    late = len(rows) - int(np.sum(count <= 5 * median))
    wrong = sum(float(row["mean_off"]) > MEAN_OFF or float(row["factor"]) > FACTOR for row in settled)
    print(f"{name}: {len(settled)} of {len(rows)} settled, median after {median:.0f} evaluations; {late} had not by five times that; {wrong} settled and wrong")


if __name__ == "__main__":
    main()
