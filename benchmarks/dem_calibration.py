"""Calibrations of the engine's own triaxial test against curves that it made at known parameters: evaluations until the answer is as good as the truth.

    python benchmarks/dem_calibration.py --packing packing_1000.csv --other packing_2000.csv [--methods posterior iterative-bayesian] [--seeds 1 2] [-o results.jsonl] [--figure FILE]

Three references, of other parameters and packings each, drained to 20 % of axial strain at 0.5 MPa: one on the calibration's own packing (at another density
scaling), one on --other, one on a packing that `graincal pack` prepares. The floor of a reference is the mean error (Eq. 6) of three runs at the true
parameters on the calibration's packing: what the truth itself comes to. Beside it stands what runs at the true parameters on that packing are apart, which is
the same where the reference is of it. After every batch, three fresh runs are made at the method's answer; a method is
through when their mean error is at most 1.2 times the floor; "at the end" is their error at the last answer. Those three are not counted; runs that "posterior, early stop" stops are. "posterior, first look" begins with a calibration of the same
reference by a packing of 250 particles, 143 evaluations whose hours are counted and whose number is not. "posterior, three packings" spreads its runs over the calibration's
packing and two more that are prepared. "posterior, its packing" calibrates on the packing that the reference was made on, so that the floor is what runs are apart. Finished calibrations are kept in the file of results
and not run again. --figure draws the posteriors' 90 % intervals beside the truths.
"""

from __future__ import annotations

import argparse
import itertools
import json
import time
from functools import partial
from pathlib import Path

import numpy as np

import graincal as gc
from graincal.dem.preparation import prepare
from graincal.execution import available_cores
from graincal.inference import IterativeBayesianFilter, PosteriorFilter, Stop
from graincal.inference.likelihood.errors import observable_errors, sample_errors
from graincal.inference.posterior.first_look import FirstLook

SPACE = gc.ParameterSpace.paper()
STRAIN = np.arange(0.0, 0.2001, 0.004)
OBSERVABLES = ("stress_ratio", "volumetric_strain")
TRUTHS = {"own packing": (8.72, 0.227, 28.1, 0.079, 0.569), "other packing": (8.0, 0.3, 38.0, 0.3, 0.4), "prepared packing": (9.4, 0.15, 22.0, 0.2, 0.6)}
CONFINING_PRESSURE = 0.5e6

ON_ITS_PACKING = "posterior, its packing"
METHODS = ("posterior", "posterior, first look", "posterior, early stop", "posterior, three packings", ON_ITS_PACKING, "iterative-bayesian")
LOOK = {"first_batch": 60, "batch": 20, "stop": Stop(max_evaluations=160, max_iterations=False, posterior_shift=False)}

# What a curve of a simulation is read to, of its peak: its own scatter is the simulator's, which the posterior learns.
READING = 0.002


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packing", required=True)
    parser.add_argument("--other", required=True)
    parser.add_argument("--methods", nargs="*", default=["posterior", "iterative-bayesian"], choices=METHODS)
    parser.add_argument("--references", nargs="*", default=list(TRUTHS), choices=list(TRUTHS))
    parser.add_argument("--seeds", nargs="*", type=int, default=[1, 2])
    parser.add_argument("--max-evaluations", type=int, default=100, help="of the posterior method")
    parser.add_argument("--max-iterations", type=int, default=8, help="of 80 evaluations each, of the paper's method")
    parser.add_argument("--threads", type=int, default=available_cores())
    parser.add_argument("-o", "--output", type=Path, default=Path("dem_calibration.jsonl"))
    parser.add_argument("--figure", type=Path)
    arguments = parser.parse_args()

    own = gc.Packing.read(arguments.packing)
    packings = {"own packing": lambda: own, "other packing": lambda: gc.Packing.read(arguments.other), "prepared packing": lambda: prepare(1000, 0.68)}
    done = [json.loads(line) for line in arguments.output.read_text().splitlines()] if arguments.output.exists() else []
    for method, seed, name in itertools.product(arguments.methods, arguments.seeds, arguments.references):
        if any((row["reference"], row["method"], row["seed"]) == (name, method, seed) for row in done):
            continue
        truth = np.array(TRUTHS[name])
        of_reference = packings[name]()
        packing = of_reference if method == ON_ITS_PACKING else own
        known = next((row for row in done if row["reference"] == name and (row["method"] == ON_ITS_PACKING) == (method == ON_ITS_PACKING)), None)
        reference = _reference(of_reference, truth)
        floor = known["floor"] if known else _fresh(packing, truth, reference, arguments.threads)
        apart = known["apart"] if known else _fresh(packing, truth, _reference(packing, truth), arguments.threads)
        found = calibrate(packing, reference, method, seed, floor, arguments)
        done.append({"reference": name, "method": method, "seed": seed, "floor": floor, "apart": apart, "truth": truth.tolist(), **found})
        with arguments.output.open("a") as file:
            file.write(json.dumps(done[-1]) + "\n")
    print_table(done)
    if arguments.figure:
        draw([row for row in done if row["method"] == "posterior"], arguments.figure)


def _test(packing: gc.Packing | list[gc.Packing], density_scaling: float = 1e3) -> gc.TriaxialTest:
    return gc.TriaxialTest(packing, CONFINING_PRESSURE, density_scaling=density_scaling)


def _reference(packing: gc.Packing, truth: np.ndarray) -> gc.Reference:
    """One run, as a laboratory has one test."""
    (response,) = _test(packing, 990.0).simulate(truth, at=STRAIN, threads=1)
    curves = {name: response.values[name] for name in OBSERVABLES}
    errors = {name: READING * float(np.abs(values).max()) for name, values in curves.items()}
    return gc.Reference(STRAIN, curves, measurement_errors=errors, simulated=True)


def _fresh(packing: gc.Packing, theta: np.ndarray, reference: gc.Reference, threads: int) -> float:
    """The mean error of three runs that differ by their density scaling alone, percent; infinite where one fails."""
    errors = []
    for scaling in (997.0, 1001.0, 1003.0):
        (response,) = _test(packing, scaling).simulate(theta, at=STRAIN, threads=threads)
        if isinstance(response, gc.Failure):
            return float("inf")
        pairs = observable_errors(response.observables(OBSERVABLES)[None], reference)
        errors.append(float(sample_errors(pairs, reference.shares)[0]))
    return float(np.mean(errors))


def calibrate(packing: gc.Packing, reference: gc.Reference, method: str, seed: int, floor: float, arguments: argparse.Namespace) -> dict:
    """One calibration: what it cost until its answer was as good as the truth, and in all."""
    evaluations, failures, stopped, seconds, particle_steps, through, last = 0, 0, 0, 0.0, 0.0, None, float("nan")
    if method.startswith("posterior"):
        look = None
        if method == "posterior, first look":
            cheap = _test(prepare(250, 0.68))
            filter = PosteriorFilter(SPACE, reference, seed=seed, discrepancy=False, **LOOK)
            while not filter.finished:
                spent = _evaluate(filter, cheap, arguments.threads)
                seconds, particle_steps = seconds + spent[0], particle_steps + spent[1]
            usable = filter.evaluations.usable
            look = FirstLook(filter.evaluations.theta[usable], (filter.evaluations.responses[0][usable],))
        limits = Stop(max_evaluations=arguments.max_evaluations, max_iterations=False)
        filter = PosteriorFilter(SPACE, reference, seed=seed, first_look=look, discrepancy=False, stop=limits, early_stop=method == "posterior, early stop")
    else:
        only_s = Stop(gl_error_increment=False, error=False, error_increment=False, max_iterations=arguments.max_iterations)
        filter = IterativeBayesianFilter(SPACE, reference, seed=seed, stop=only_s)
    several = method == "posterior, three packings"
    test = _test([packing, *(prepare(1000, 0.68, seed=other) for other in (2, 3))] if several else packing)
    limit = 1.2 * floor
    start = time.perf_counter()
    while not filter.finished:
        spent = _evaluate(filter, test, arguments.threads)
        seconds, particle_steps = seconds + spent[0], particle_steps + spent[1]
        evaluations += len(filter.iterations[-1].samples)
        failures += int(filter.iterations[-1].failed.sum())
        stopped += 0 if filter.iterations[-1].stopped is None else int(filter.iterations[-1].stopped.sum())
        answer = _answer(filter)
        if answer is not None and (through is None or filter.finished):
            last = _fresh(packing, answer, reference, arguments.threads)
            if through is None and last <= limit:
                through = {"evaluations": evaluations, "hours": seconds / 3600, "error": last}
        best = float(np.nanmin(np.concatenate([iteration.errors[iteration.complete] for iteration in filter.iterations])))
        print(f"{method}, seed {seed}: {evaluations} evaluations, best {best:.2f} %, answer {last:.2f} % (floor {floor:.2f} %)", flush=True)
    posterior = filter.posterior
    return {
        "through": through,
        "end": last,
        "evaluations": evaluations,
        "failures": failures,
        "stopped": stopped,
        "core_hours": seconds / 3600,
        "wall_hours": (time.perf_counter() - start) / 3600,
        "particle_steps": particle_steps,
        "best": best,
        "stopped_by": filter.stopped_by,
        "answer": None if answer is None else answer.tolist(),
        "mean": posterior.mean().tolist(),
        "std": posterior.std().tolist(),
        "samples": _thinned(posterior),
        "held_out": list(filter.emulation.held_out) if isinstance(filter, PosteriorFilter) else None,
    }


def _evaluate(filter, test: gc.TriaxialTest, threads: int) -> tuple[float, float]:
    """One batch; the seconds and the particle-steps that it took."""
    samples, (early_stop, *_), seconds, particle_steps = filter.ask(), filter.early_stops, 0.0, 0.0
    experiment = gc.Experiment("test", test, filter.thinnings[0].whole)
    responses = np.full((len(samples), len(STRAIN), 2), np.nan)
    failed, stopped = np.zeros((2, len(samples)), dtype=bool)

    for row, outcome in experiment.evaluate(samples, threads, partial(early_stop.hopeless, 0) if early_stop else None):
        seconds += outcome.details.get("seconds", 0.0)
        particle_steps += outcome.details.get("particle_steps", 0.0)
        if isinstance(outcome, gc.Response):
            responses[row] = experiment.observables(outcome)
            stopped[row] = outcome.stopped
        else:
            failed[row] = True
    filter.tell(samples, responses, failed, stopped=stopped)
    return seconds, particle_steps


def _answer(filter) -> np.ndarray | None:
    if isinstance(filter, PosteriorFilter):
        return filter.emulation.answer if filter.emulation else None
    last = filter.iterations[-1]
    return None if last.most_probable is None else last.samples.theta[last.most_probable]


def _thinned(posterior: gc.Posterior) -> list[list[float]]:
    """Two hundred equally weighted samples of a posterior."""
    rows = np.random.default_rng(0).choice(len(posterior.weights), size=200, p=posterior.weights / posterior.weights.sum())
    return np.round(posterior.samples[rows], 4).tolist()


def print_table(rows: list[dict]) -> None:
    """A row for each calibration, with the rank of the truth among the posterior's samples, in percent, for each parameter."""
    print(
        f"\n{'reference':18}{'method':24}{'seed':>5}{'floor %':>9}{'apart %':>9}{'through at':>12}{'hours':>7}{'error %':>9}{'at the end %':>14}{'in all':>8}{'hours':>7}{'best %':>8}   ranks of the truth, %"
    )
    for row in sorted(rows, key=lambda row: (row["reference"], row["method"], row["seed"])):
        samples, through = np.array(row["samples"]), row["through"]
        ranks = (100 * np.mean(samples < np.array(row["truth"]), axis=0)).round().astype(int)
        reached = f"{through['evaluations']:>12}{through['hours']:>7.2f}{through['error']:>9.2f}" if through else f"{'never':>12}{'':>16}"
        print(
            f"{row['reference']:18}{row['method']:24}{row['seed']:>5}{row['floor']:>9.2f}{row['apart']:>9.2f}{reached}{row['end']:>14.2f}{row['evaluations']:>8}{row['core_hours']:>7.2f}{row['best']:>8.2f}   "
            + " ".join(f"{rank:>3}" for rank in ranks)
        )


def draw(rows: list[dict], file: Path) -> None:
    """The 90 % interval and the median of each posterior, and the truth, for each parameter."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    rows = sorted(rows, key=lambda row: (list(TRUTHS).index(row["reference"]), row["seed"]))
    places = -np.arange(len(rows))
    figure, axes = plt.subplots(1, SPACE.size, figsize=(11, 0.42 * len(rows) + 1.2), sharey=True, layout="constrained")
    for k, axis in enumerate(axes):
        low, middle, high = np.quantile([np.array(row["samples"])[:, k] for row in rows], [0.05, 0.5, 0.95], axis=1)
        axis.hlines(places, low, high, color="#0072b2", linewidth=3, label="90 % interval")
        axis.plot(middle, places, "|", color="#0072b2", markersize=12, label="median")
        axis.plot([row["truth"][k] for row in rows], places, "D", color="black", markersize=5, label="truth")
        unit = f" [{SPACE.units[k]}]" if SPACE.units[k] not in ("", "-") else " [-]"
        axis.set(xlim=(SPACE.low[k], SPACE.high[k]), xlabel=f"{SPACE.names[k]}{unit}")
        axis.grid(axis="x", color="0.9")
    axes[0].set_yticks(places, [f"{row['reference']}, seed {row['seed']}" for row in rows])
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=3, frameon=False)
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    main()
