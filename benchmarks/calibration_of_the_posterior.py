"""Whether the posterior method's probabilities are right: ranks of the truth among samples of the posterior (Talts et al. 2018).

    python benchmarks/calibration_of_the_posterior.py [--model-error] [--repetitions N] [--processes N] [--results FILE] [--figure FILE]

Each repetition draws five parameters from the prior, the paper's ranges; its reference is a laboratory's: the mean response of a triaxial test in
closed form and errors as the error model states them, an Ornstein-Uhlenbeck process of known deviation whose length is one of the hypotheses. The
method calibrates with its defaults, but for what the model cannot reproduce, against runs that scatter, smoothly along the curve, by one and a half percent of a usual peak. Were its
posteriors exact, the rank of each true parameter among 99 draws would be uniform, and so would that of the truth's log likelihood as the method
knows it. Printed are how far the ranks' distribution is from uniform, how probable that is, and whether it stays within a band that any of the six
would leave by chance in one case of twenty (Säilynoja, Bürkner, Vehtari 2022); how often intervals hold the truth; and the same for posteriors
shrunk to 0.8 of their deviation, which ought to be refused. With --model-error each reference has an error of the model too, of one of the sizes that the method weighs, as probable as it
holds them, and the method allows for it by default. With --results, repetitions are appended to a CSV as they end, and those it holds are
not run again.
"""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np
from kept_rows import append_row, read_rows
from numpy.typing import NDArray
from problems import PROBLEMS, SPACE, STRAIN
from rank_table import FAMILYWISE, show
from scipy.stats import binom
from threadpoolctl import threadpool_limits

import graincal as gc
from graincal.inference import PosteriorFilter
from graincal.inference.likelihood.error_model import CORRELATION_LENGTHS, DISCREPANCIES, DISCREPANCY_LENGTH, DISCREPANCY_PRIOR
from graincal.inference.likelihood.likelihood import log_likelihood, marginal
from graincal.inference.sampling.ranks import UniformBand, rank

PROBLEM = PROBLEMS["triaxial"]

# Standard deviations of the laboratory's errors, of the stress ratio and of the volumetric strain, whatever the truth: or they would tell of it.
DEVIATIONS = np.array([0.04, 0.001])

# Of runs at one Theta: the deviations of the two, and the length over which these are alike, in lengths of the curve.
SCATTER, SCATTER_LENGTH = np.array([0.015 * 2.0, 0.015 * 0.03]), 0.2

DRAWS, SHRUNK = 99, 0.8
QUANTITIES = (*SPACE.names, "log likelihood")
# Under the mean response itself, which the method does not know: where the emulator's doubt widens the posterior, the truth ranks high.
UNKNOWN = "exact likelihood"
FIELDS = ("repetition", "evaluations", "stopped_by", "held_out", "seconds", *QUANTITIES, UNKNOWN, *(f"shrunk {name}" for name in (*QUANTITIES, UNKNOWN)))

APART = np.abs(STRAIN[:, None] - STRAIN[None, :]) / (STRAIN[-1] - STRAIN[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repetitions", type=int, default=300)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--model-error", action="store_true", help="what the model cannot reproduce is in each reference, and allowed for")
    parser.add_argument("--results", type=Path, help="a CSV to go on with, of either kind alone")
    parser.add_argument("--figure", type=Path, help="where to draw the distributions and their band")
    arguments = parser.parse_args()
    rows = {row["repetition"]: row for row in read_rows(arguments.results)}
    left = [number for number in range(arguments.repetitions) if str(number) not in rows]
    for row in _run(left, arguments.processes, arguments.model_error):
        rows[row["repetition"]] = row
        append_row(arguments.results, row, FIELDS)
    done = [rows[key] for key in sorted(rows, key=int)[: arguments.repetitions]]
    report(done)
    if arguments.figure:
        draw(done, arguments.figure)


def _run(left: list[int], processes: int, model_error: bool):
    if processes == 1:
        yield from (repetition(number, model_error) for number in left)
        return
    with ProcessPoolExecutor(processes) as pool:
        for future in as_completed([pool.submit(repetition, number, model_error) for number in left]):
            yield future.result()


def repetition(number: int, model_error: bool) -> dict[str, str]:
    """One calibration, as a row of the results."""
    with threadpool_limits(1):
        rng = np.random.default_rng([number, 7])
        truth = SPACE.from_unit(rng.random(SPACE.size))
        errors = np.linalg.cholesky(np.exp(-APART / rng.choice(CORRELATION_LENGTHS))) @ rng.standard_normal((len(STRAIN), 2))
        values = PROBLEM.curves(truth[None])[0] + DEVIATIONS * errors
        if model_error:
            smooth = np.linalg.cholesky(np.exp(-0.5 * (APART / DISCREPANCY_LENGTH) ** 2) + 1e-10 * np.eye(len(STRAIN)))
            values = values + rng.choice(DISCREPANCIES, p=DISCREPANCY_PRIOR) * np.abs(values).max(axis=0) * (smooth @ rng.standard_normal((len(STRAIN), 2)))
        deviations = dict(zip(PROBLEM.observables, DEVIATIONS.tolist()))
        reference = gc.Reference(STRAIN, dict(zip(PROBLEM.observables, values.T)), measurement_errors=deviations)
        started = time.perf_counter()
        filter = PosteriorFilter(SPACE, reference, seed=number, discrepancy=model_error)
        while not filter.finished:
            samples = filter.ask()
            filter.tell(samples, runs(samples.theta, rng))
        seconds = time.perf_counter() - started
        posterior = filter.posterior

        def quantities(theta: NDArray) -> NDArray:
            (model,) = filter.errors
            exact = marginal(log_likelihood(PROBLEM.curves(theta), reference, model), model.log_prior)
            return np.column_stack([theta, filter.emulation.log_likelihood(SPACE.to_unit(theta)), exact])

        known = quantities(truth[None])[0]
        mean = posterior.mean()
        found = [rank(known, quantities(theta), posterior.weights, DRAWS, rng) for theta in (posterior.samples, mean + SHRUNK * (posterior.samples - mean))]
    held_out = max(filter.emulation.held_out)
    row = (number, len(filter.evaluations), filter.stopped_by, f"{held_out:.4f}", f"{seconds:.1f}", *found[0], *found[1])
    return {field: str(value) for field, value in zip(FIELDS, row)}


def runs(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Responses (N, T, J) that scatter as simulations do: alike over a part of the curve."""
    factor = np.linalg.cholesky(np.exp(-0.5 * (APART / SCATTER_LENGTH) ** 2) + 1e-8 * np.eye(len(STRAIN)))
    noise = np.einsum("st,ntj->nsj", factor, rng.standard_normal((len(theta), len(STRAIN), 2)))
    return PROBLEM.curves(theta) + SCATTER * noise


def report(rows: list[dict[str, str]]) -> None:
    count = len(rows)
    evaluations = np.array([int(row["evaluations"]) for row in rows])
    settled = sum(row["stopped_by"] == "posterior_shift" for row in rows)
    seconds = np.median([float(row["seconds"]) for row in rows])
    print(f"{count} repetitions of {np.median(evaluations):.0f} evaluations (median), {settled} of them settled; {seconds:.0f} s each")
    print(f"held-out error, in parts of the responses' spread: {np.median([float(row['held_out']) for row in rows]):.3f} (median)")
    for prefix, title in (("", "posterior as reported"), ("shrunk ", f"posterior shrunk to {SHRUNK:g} of its deviation")):
        show(title, {name: np.array([int(row[prefix + name]) for row in rows]) for name in (*QUANTITIES, UNKNOWN)}, DRAWS, QUANTITIES)
    chance = [binom.ppf((0.025, 0.975), count, level) / count for level in (0.5, 0.9)]
    print(f"\nby chance alone, in 50 %: {chance[0][0]:.2f} to {chance[0][1]:.2f}; in 90 %: {chance[1][0]:.2f} to {chance[1][1]:.2f} (each in 95 of 100)")


def draw(rows: list[dict[str, str]], file: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    band = UniformBand.of(len(rows), DRAWS, 1 - FAMILYWISE / len(QUANTITIES), np.random.default_rng(1))
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True, layout="constrained")
    for axis, prefix, title in zip(axes, ("", "shrunk "), ("the posterior as reported", f"shrunk to {SHRUNK:g} of its deviation")):
        lower, upper = band.edges - band.below
        axis.fill_between(band.below, lower, upper, step="mid", color="0.88", label=f"band of {100 * (1 - FAMILYWISE):.0f} % for all six")
        for name in QUANTITIES:
            ranks = np.array([int(row[prefix + name]) for row in rows])
            axis.step(band.below, band.distribution(ranks) - band.below, where="mid", linewidth=1, label=name)
        axis.set(title=title, xlabel="rank of the truth, as a part of the draws", xlim=(0, 1))
    axes[0].set_ylabel("part of ranks below, minus uniform")
    axes[1].legend(fontsize=7, loc="lower left")
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    main()
