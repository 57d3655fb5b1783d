"""Whether advice comes true: how far further tests narrow the parameters, as foretold by `graincal advise` and as found when a campaign is calibrated jointly with each.

    python benchmarks/advice.py --folder DIR [--truths 6] [--samples 100] [--filling 200] [--evaluations 400] [--strain 0.05] [--workers N]

The campaign is that of `graincal demo`: five parameters over the paper's ranges, a drained test at 0.5 MPa on 500 grains, whose reference was made on a sibling packing. Truths are drawn from its posterior. For
each, three further tests are made at it, on another sibling each, with measurement errors as advice takes them; and the campaign is calibrated anew with its own reference and that of the new test.
These calibrations learn from runs of both tests together, which are made once for each test: some that fill the ranges, and some at draws from the campaign's posterior. Printed are, for each test and
parameter, the standard deviation afterwards over that now, as foretold and as the mean found over the truths, each with its standard error, and by how many of these the two differ; and the gain, foretold in nats, beside half the logarithm
of the ratio of the determinants of the posterior's covariance, which is the same of Gaussians. All is kept in the folder, and the same command continues where it was interrupted.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import graincal as gc
from graincal import demo
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.run.advice import APART, Advice
from graincal.campaign.run.candidate_tests import CandidateTest, candidate_test
from graincal.campaign.run.exploring import fill
from graincal.campaign.run.running import begin_or_resume
from graincal.dem.siblings import siblings
from graincal.inference.likelihood.error_model import error_model
from graincal.inference.sampling.proposal import systematic_resampling

FIRST_SIBLING = 201
"""The seed of the packing that the first truth's tests are made on; the study of packings has others."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("advice"))
    parser.add_argument("--truths", type=int, default=6)
    parser.add_argument("--samples", type=int, default=100, help="draws from the posterior, for advice and for the runs of both tests")
    parser.add_argument("--filling", type=int, default=200, help="runs of both tests that fill the ranges")
    parser.add_argument(
        "--evaluations", type=int, default=400, help="the most of the campaign, and of each joint calibration beside the runs that it learns from"
    )
    parser.add_argument("--strain", type=float, default=0.05, help="the last axial strain of all tests")
    parser.add_argument("--workers", type=int)
    arguments = parser.parse_args()
    workers = arguments.workers or "all"
    campaign = begin_or_resume(arguments.folder / "campaign", lambda: base(arguments.strain, arguments.evaluations, workers))
    (experiment,) = campaign.experiments
    pressure = experiment.model.confining_pressure
    words = [f"triaxial {2 * pressure:g} to {arguments.strain:g}", f"undrained to {arguments.strain:g}", "isotropic"]
    advice = gc.advise(campaign, words, samples=arguments.samples, workers=workers)
    truths = draws(campaign, arguments.truths)
    found = {test.name: [] for test in advice.tests}
    for number, test in enumerate(candidate_test(each, experiment) for each in words):
        if test.name in advice.not_judged:
            print(f"{test.name} is left out: {advice.not_judged[test.name]}", flush=True)
            continue
        runs = runs_of_both(campaign, test, advice.theta, arguments.filling, arguments.folder / f"runs-{number}", workers)
        for truth, theta in enumerate(truths):
            measured = made(campaign, test, theta, FIRST_SIBLING + truth)
            joint = jointly(campaign, test, measured, runs, arguments.evaluations, arguments.folder / f"test-{number}-truth-{truth}", workers)
            found[test.name].append(covariance(joint))
            said = joint.posterior.std() / campaign.posterior.std()
            print(
                f"{test.name}, truth {truth + 1}: "
                + ", ".join(f"{name} {share:.2f}" for name, share in zip(campaign.space.names, said))
                + ("" if joint.settled else ", not settled"),
                flush=True,
            )
    show(campaign, advice, {name: np.array(each) for name, each in found.items()})


def base(strain: float, evaluations: int, workers: int | str) -> Calibration:
    """The demo's calibration, up to an axial strain."""
    whole = demo.reference(demo.sibling())
    rows = whole.control <= strain * (1 + 1e-9)
    reference = gc.Reference(
        whole.control[rows], {name: values[rows] for name, values in whole.observables.items()}, None, whole.measurement_errors, simulated=True
    )
    asked = demo.calibration(demo.packing(), reference, workers=workers)
    return Calibration(asked.space, asked.experiments, filter_options=asked.filter_options, stop=gc.Stop(max_evaluations=evaluations), workers=workers)


def draws(campaign: gc.Result, count: int) -> NDArray[np.float64]:
    """Of the posterior, (count, n), not those of the advice."""
    return campaign.posterior.samples[systematic_resampling(campaign.posterior.weights, count, np.random.default_rng(101))]


def together(campaign: gc.Result, test: CandidateTest, measured: gc.Reference) -> list[gc.Experiment]:
    return [*campaign.experiments, gc.Experiment(test.name, test.model, measured)]


def runs_of_both(campaign: gc.Result, test: CandidateTest, theta: NDArray[np.float64], filling: int, folder: Path, workers: int | str) -> list[Path]:
    """Libraries of the campaign's test and another: over the ranges, and at draws from the posterior."""
    nothing = test.reference(np.ones((len(test.at), len(test.observables))))
    asked = Calibration(campaign.space, together(campaign, test, nothing), workers=workers)
    return [fill(asked, folder / "ranges", filling), fill(asked, folder / "posterior", points=theta)]


def made(campaign: gc.Result, test: CandidateTest, theta: NDArray[np.float64], seed: int) -> gc.Reference:
    """A test at a truth, on a sibling of the campaign's packing, with errors of measurement."""
    (packing,) = siblings(test.model.packing, 1, first_seed=seed)
    (curve,) = replace(test.model, packing=packing, packings=()).simulate([theta], at=test.at)
    exact = test.reference(curve.observables(test.observables), simulated=True)
    errors = error_model(exact, discrepancy=False)
    rng = np.random.default_rng(seed)
    factor = np.linalg.cholesky(errors.covariances[rng.integers(errors.size)])
    off = (factor @ rng.standard_normal(len(factor))).reshape(len(test.observables), -1).T
    return test.reference(exact.values + off, simulated=True)


def jointly(
    campaign: gc.Result, test: CandidateTest, measured: gc.Reference, runs: Sequence[Path], evaluations: int, folder: Path, workers: int | str
) -> gc.Result:
    asked = lambda: Calibration(campaign.space, together(campaign, test, measured), stop=gc.Stop(max_evaluations=evaluations), workers=workers)  # noqa: E731
    return begin_or_resume(folder, asked, runs)


def covariance(result: gc.Result) -> NDArray[np.float64]:
    """The posterior's, (n, n)."""
    return np.cov(result.posterior.samples.T, aweights=result.posterior.weights, ddof=0)


def show(campaign: gc.Result, advice: Advice, found: dict[str, NDArray[np.float64]]) -> None:
    """A table for each test, and the order of the tests as foretold and as found."""
    now, gains, kept = covariance(campaign), {}, []
    for test in advice.tests:
        after = found[test.name]
        shares = np.sqrt(np.diagonal(after, axis1=1, axis2=2)) / campaign.posterior.std()
        gains[test.name] = 0.5 * (np.linalg.slogdet(now)[1] - np.linalg.slogdet(after)[1])
        print(f"\n{test.name}\n{'':12}{'foretold':>16}{'found':>16}{'apart, standard errors':>26}")
        for name, *figures in zip(campaign.space.names, test.shares, test.share_errors, shares.mean(axis=0), error(shares)):
            print(row(name, *figures))
            kept.append(abs(apart(*figures)) <= APART)
        print(row("gain [nats]", test.information, test.information_error, gains[test.name].mean(), error(gains[test.name])))
    print("\norder foretold: " + "; ".join(test.name for test in advice.tests))
    print("order found:    " + "; ".join(sorted(gains, key=lambda name: -gains[name].mean())))
    print("cannot be told apart beforehand: " + ("; ".join(f"{one.name} and {other.name}" for one, other in advice.alike()) or "none"))
    print(f"\nreductions foretold within two standard errors of those found: {sum(kept)} of {len(kept)}")
    print("order of the tests that can be told apart: " + ("the same" if same_order(advice, gains) else "another"))


def same_order(advice: Advice, gains: dict[str, NDArray[np.float64]]) -> bool:
    """Whether the gains found do not reverse the order of any two tests that can be told apart, beforehand and by what was found: truth by truth, by more than two standard errors."""
    alike = [{one.name, other.name} for one, other in advice.alike()]
    for place, one in enumerate(advice.tests):
        for other in advice.tests[place + 1 :]:
            difference = gains[one.name] - gains[other.name]
            if {one.name, other.name} not in alike and difference.mean() < -APART * error(difference):
                return False
    return True


def row(name: str, foretold: float, foretold_error: float, mean: float, mean_error: float) -> str:
    return f"{name:12}{f'{foretold:.2f} ± {foretold_error:.2f}':>16}{f'{mean:.2f} ± {mean_error:.2f}':>16}{apart(foretold, foretold_error, mean, mean_error):>26.1f}"


def apart(foretold: float, foretold_error: float, mean: float, mean_error: float) -> float:
    """By how many standard errors two numbers differ."""
    return (mean - foretold) / np.hypot(foretold_error, mean_error)


def error(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The standard error of a mean over truths (K, ...)."""
    return values.std(axis=0, ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.full(values.shape[1:], np.nan)


if __name__ == "__main__":
    main()
