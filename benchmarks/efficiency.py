"""How many evaluations calibrations need: graincal's methods and others, on three problems in closed form over the paper's five ranges.

    python benchmarks/efficiency.py [--peers NAME=PYTHON ...] [--results FILE] [--seeds N] [--parts PART ...] [--problems NAME ...] [--methods NAME ...]

fit: evaluations until one of them has an error of at most 2 % (Eq. 6 of Hartmann, Cheng, Thornton 2022, equal shares), against a reference without
noise. posterior: evaluations until the posterior of every parameter has its mean within 0.25 standard deviations and its standard deviation within
25 % of the exact one, against a reference with independent errors of 2 % of the peak, which the method is told. Truths are drawn at random from the
inner 70 % of each range. Printed are the median and the quartiles over seeds, and how many never got there in 600 evaluations (200 for graincal's posterior
method). With early stop, a run counts as the part of it that was run. "settled" is where that one would have stopped by itself, and at how many seeds its posterior was right then.

A peer runs in the Python that --peers names for it, or in this one; one whose packages are missing is skipped. With --results, runs are appended
to a CSV as they end, and those it holds are not run again.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
from exact import exact_moments
from kept_rows import append_row, read_rows
from numpy.typing import NDArray
from problems import PROBLEMS, SPACE, STRAIN, Problem
from threadpoolctl import threadpool_limits

import graincal as gc
from graincal.inference import IterativeBayesianFilter, PosteriorFilter, Stop
from graincal.inference.likelihood.early_stop import EarlyStop
from graincal.inference.likelihood.errors import observable_errors, sample_errors

PARTS = ("fit", "posterior")
GOOD_FIT = 2.0
MEAN_WITHIN, DEVIATION_WITHIN = 0.25, 0.25
NOISE = 0.02
MOST = 600

# Of the length of the curve: next to nothing, for errors that are independent from state to state.
INDEPENDENT = 1e-3

# Where the posterior method has not arrived after as many, it counts as never.
MOST_POSTERIOR = 200

FIELDS = ("part", "problem", "method", "seed", "evaluations", "settled", "right", "seconds")


class Enough(Exception):
    """The goal is reached, or there are no evaluations left."""


class Goal:
    """Counts evaluations, and says when the goal is reached. `reached`: the number of them by then, None before."""

    def __init__(self, problem: Problem, reference: gc.Reference, most: int, exact: tuple[NDArray, NDArray] | None) -> None:
        self.problem, self.reference, self.most, self.exact = problem, reference, most, exact
        self.count = 0
        self.reached: int | None = None
        self.settled: int | None = None
        self.right: bool | None = None

    def evaluate(self, theta: NDArray) -> NDArray:
        """Curves (N, T, J). Raises Enough once there is nothing more to learn from the run."""
        if self.count >= self.most or (self.reached and not self.exact):
            raise Enough
        curves = self.problem.curves(np.atleast_2d(theta))
        good = np.flatnonzero(sample_errors(observable_errors(curves, self.reference), self.reference.shares) <= GOOD_FIT)
        if not self.exact and not self.reached and len(good) and self.count + good[0] < self.most:
            self.reached = self.count + int(good[0]) + 1
        self.count += len(curves)
        return curves

    def posterior(self, mean: NDArray, std: NDArray) -> bool:
        """Whether it is right, moments (n,) each."""
        if self.exact is None or self.count > self.most:
            return False
        known_mean, known_std = self.exact
        off = np.abs(np.asarray(mean) - known_mean) / known_std
        right = bool(np.all(off <= MEAN_WITHIN) and np.all(np.abs(np.asarray(std) / known_std - 1) <= DEVIATION_WITHIN))
        if right and not self.reached:
            self.reached = self.count
        return right


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", nargs="*", default=[], metavar="NAME=PYTHON", help="the Python that a peer of benchmarks/peers is to run in")
    parser.add_argument("--results", type=Path, help="a CSV to go on with")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--parts", nargs="+", default=PARTS, choices=PARTS)
    parser.add_argument("--problems", nargs="+", default=list(PROBLEMS), choices=list(PROBLEMS))
    parser.add_argument("--methods", nargs="+", default=list(METHODS), choices=list(METHODS))
    arguments = parser.parse_args()
    pythons = dict(peer.split("=", 1) for peer in arguments.peers)
    rows = {(row["part"], row["problem"], row["method"], row["seed"]): row for row in read_rows(arguments.results)}
    with threadpool_limits(1):
        for part in arguments.parts:
            for name in arguments.problems:
                print(f"\n{part}: {name}")
                print(f"{'':34}{'median':>8}{'quartiles':>14}{'never':>12}{'settled':>9}{'right':>10}{'s a run':>9}", flush=True)
                for method in arguments.methods:
                    runs, missing = [], None
                    for seed in range(arguments.seeds):
                        run = rows.get((part, name, method, str(seed)))
                        if run is None and method not in LEFT_OUT[part]:
                            run = calibrate(part, PROBLEMS[name], method, seed, pythons)
                            if isinstance(run, str):
                                missing = run
                                break
                            append_row(arguments.results, run, FIELDS)
                        if run:
                            runs.append(run)
                    show(method, runs, missing)


def calibrate(part: str, problem: Problem, method: str, seed: int, pythons: dict[str, str]) -> dict[str, str] | str:
    """One run, as a row of the results; or why there is none."""
    reference = problem.reference(seed, NOISE if part == "posterior" else 0.0)
    exact = exact_moments(problem.name, seed, NOISE) if part == "posterior" else None
    goal = Goal(problem, reference, MOST_POSTERIOR if method in (POSTERIOR, STOPPED) else MOST, exact)
    started = time.perf_counter()
    try:
        missing = METHODS[method](goal, seed, pythons)
    except Enough:
        missing = None
    if missing:
        return missing
    seconds = time.perf_counter() - started
    values = (part, problem.name, method, seed, goal.reached, goal.settled, goal.right, f"{seconds:.1f}")
    return {field: "" if value is None else str(value) for field, value in zip(FIELDS, values)}


def posterior_method(goal: Goal, seed: int, pythons: dict[str, str], stops: bool = False) -> None:
    """graincal's posterior method at its defaults, but for a discrepancy that these models do not have; once without an end until the goal is reached, and once to where it settles by itself.
    stops: a run that is stopped early counts as the part of an evaluation that was run."""
    with suppress(Enough):
        _posterior_method(goal, seed, stops, posterior_shift=False)
    if not goal.exact:
        return
    goal.count = 0
    filter = _posterior_method(goal, seed, stops, posterior_shift=Stop().posterior_shift)
    if filter.stopped_by == "posterior_shift":
        before = filter.found[-2].posterior
        goal.settled, goal.right = goal.count - len(filter.iterations[-1].samples), goal.posterior(before.mean(), before.std())


def _posterior_method(goal: Goal, seed: int, stops: bool, posterior_shift: float | bool) -> PosteriorFilter:
    stop = Stop(posterior_shift=posterior_shift, max_evaluations=MOST_POSTERIOR)
    filter = PosteriorFilter(
        SPACE, goal.reference, correlation_length=INDEPENDENT if goal.exact else None, discrepancy=False, stop=stop, seed=seed, early_stop=stops
    )
    while not filter.finished:
        samples, early_stop = filter.ask(), filter.early_stops[0] if stops else None
        responses = goal.evaluate(samples.theta)
        reached = [_states_run(early_stop, int(id), response) for id, response in zip(samples.ids, responses)]
        for response, states in zip(responses, reached):
            response[states:] = np.nan
        goal.count -= sum(1 - states / len(STRAIN) for states in reached)
        filter.tell(samples, responses, stopped=np.array(reached) < len(STRAIN))
        goal.posterior(filter.posterior.mean(), filter.posterior.std())
        if goal.exact and goal.reached and posterior_shift is False:
            break
    return filter


def _states_run(early_stop: EarlyStop | None, id: int, response: NDArray) -> int:
    """How many states of a response (T, J) are run."""
    hopeless = (states for states in range(1, len(response)) if early_stop and early_stop.hopeless(0, id, response[:states]))
    return next(hopeless, len(response))


def iterative_bayesian(goal: Goal, seed: int, pythons: dict[str, str]) -> None:
    """The paper's method in graincal, its criteria switched off so that it goes on to the last evaluation."""
    stop = Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=False, max_evaluations=MOST)
    filter = IterativeBayesianFilter(SPACE, goal.reference, stop=stop, seed=seed)
    while not filter.finished:
        samples = filter.ask()
        filter.tell(samples, goal.evaluate(samples.theta))
        goal.posterior(filter.posterior.mean(), filter.posterior.std())
        if goal.exact and goal.reached:
            return


def peer(module: str, *options: str) -> Callable[[Goal, int, dict[str, str]], str | None]:
    """A method of benchmarks/peers, run in a process of its own."""

    def calibrate(goal: Goal, seed: int, pythons: dict[str, str]) -> str | None:
        folder = Path(__file__).parent / "peers"
        environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        errors = goal.reference.measurement_errors
        task = {
            "names": SPACE.names,
            "low": SPACE.low.tolist(),
            "high": SPACE.high.tolist(),
            "observables": goal.reference.names,
            "control": goal.reference.control.tolist(),
            "observed": goal.reference.values.tolist(),
            "deviations": [errors[name].absolute for name in goal.reference.names] if errors else None,
            "seed": seed,
        }
        command = [pythons.get(module, sys.executable), folder / "task.py", module, *options]
        said = tempfile.TemporaryFile("w+")
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said, text=True, env=environment)
        try:
            process.stdin.write(json.dumps(task) + "\n")
            process.stdin.flush()
            for line in process.stdout:
                message = json.loads(line)
                if "missing" in message:
                    return f"skipped, no {message['missing']} in {command[0]}"
                if "evaluate" in message:
                    curves = goal.evaluate(np.array(message["evaluate"]))
                    process.stdin.write(json.dumps(curves.tolist()) + "\n")
                    process.stdin.flush()
                else:
                    goal.posterior(*message["posterior"])
                    if goal.exact and goal.reached:
                        return None
            if process.wait():
                said.seek(0)
                raise SystemExit(f"{module} ended in an error:\n{said.read()[-3000:]}")
        finally:
            process.kill()
            process.communicate()
            said.close()
        return None

    return calibrate


POSTERIOR, STOPPED = "graincal, posterior", "graincal, posterior, early stop"
METHODS: dict[str, Callable[[Goal, int, dict[str, str]], str | None]] = {
    POSTERIOR: posterior_method,
    STOPPED: partial(posterior_method, stops=True),
    "graincal, iterative-bayesian": iterative_bayesian,
    "GrainLearning 2.0.5, best": peer("grain_learning", "settings=best"),
    "GrainLearning 2.0.5, defaults": peer("grain_learning", "settings=defaults"),
    "CMA-ES": peer("cma_es"),
    "Bayesian optimisation": peer("bayesian_optimisation"),
    "pyABC": peer("py_abc"),
    "PyVBMC": peer("vbmc"),
    "sbi": peer("npe"),
}
LEFT_OUT = {"fit": (STOPPED, "PyVBMC", "sbi"), "posterior": ("CMA-ES", "Bayesian optimisation")}
"""Methods that have no part in one: a best fit is not stopped, two methods need errors to be told of, and looking for a best fit gives no posterior."""


def show(method: str, runs: list[dict[str, str]], missing: str | None) -> None:
    if missing or not runs:
        print(f"{method:34}{missing or '-':>8}", flush=True)
        return
    # One that never got there took more than any that did.
    counts = np.sort([float(run["evaluations"] or np.inf) for run in runs])
    quartiles = [counts[min(int(np.ceil(q * len(counts))), len(counts)) - 1] for q in (0.25, 0.5, 0.75)]
    lower, median, upper = ("-" if np.isinf(value) else f"{value:.0f}" for value in quartiles)
    settled = [float(run["settled"]) for run in runs if run["settled"]]
    right = sum(run["right"] == "True" for run in runs)
    own = f"{np.median(settled):>9.0f}{right:>4} of {len(settled):<3}" if settled and runs[0]["part"] == "posterior" else f"{'':19}"
    seconds = np.median([float(run["seconds"]) for run in runs])
    print(f"{method:34}{median:>8}{f'{lower} to {upper}':>14}{f'{int(np.isinf(counts).sum())} of {len(runs)}':>12}{own}{seconds:>9.1f}", flush=True)


if __name__ == "__main__":
    main()
