"""What further tests may be expected to tell, in figures: the records that `advise` returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.run.candidate_tests import CandidateTest
from graincal.data import Failure, ParameterSpace
from graincal.inference.posterior.gain import Gain

COMMON = 30
"""Truths that two tests must have in common for their gains to be compared."""

APART = 2.0
"""Standard errors by which the gains of two tests must differ for one to be called the better."""

FEW_EFFECTIVE = 20.0
"""Effective samples of the posterior, in the median of the truths, below which deviations are too small by a twentieth and more, about 3 / (4 n), and the gain is too large by about 1 / (2 n) nats."""


@dataclass(frozen=True, eq=False)
class AdvisedTest:
    """A candidate test and what it is expected to tell.

    runs: how many were asked for; failures: what those without a response ended with. draws (K,): the rows of the draws (`Advice.theta`) whose runs gave one, in the order of `gain`.
    not_studied: the observables of which it is not known what packings differ by, and that of the others was taken; None where it is known of none, and left out.
    """

    test: CandidateTest
    runs: int
    failures: tuple[Failure, ...]
    draws: NDArray[np.intp]
    gain: Gain
    not_studied: tuple[str, ...] | None

    @property
    def name(self) -> str:
        """The test's."""
        return self.test.name

    @property
    def information(self) -> float:
        """The expected information gain, nats."""
        return self.gain.mean_information

    @property
    def information_error(self) -> float:
        """Its standard error, nats."""
        return self.gain.information_error

    @property
    def shares(self) -> NDArray[np.float64]:
        """The expected standard deviations of the parameters after the test, as parts of those now, (n,)."""
        return self.gain.shares

    @property
    def share_errors(self) -> NDArray[np.float64]:
        """Their standard errors, (n,)."""
        return self.gain.share_errors


@dataclass(frozen=True, eq=False)
class Advice:
    """What further tests are expected to tell of the parameters of a campaign, that of the largest gain first.

    space: the parameters. deviations (n,): their standard deviations now, in their own units. theta (K, n): the draws from the posterior that were run in each test. tests: those that
    could be judged. not_judged: the names of the others, with why. remarks: what was taken for granted, and what to bear in mind, as sentences.
    """

    space: ParameterSpace
    deviations: NDArray[np.float64]
    theta: NDArray[np.float64]
    tests: tuple[AdvisedTest, ...]
    not_judged: Mapping[str, str]
    remarks: tuple[str, ...]

    def expected_deviations(self, test: AdvisedTest) -> NDArray[np.float64]:
        """The standard deviations of the parameters after a test, (n,), in their own units."""
        return test.shares * self.deviations

    @staticmethod
    def difference(one: AdvisedTest, other: AdvisedTest) -> tuple[float, float]:
        """By how much the gain of one test is above that of another, nats, and the standard error of that: truth by truth, over those whose runs in both gave a response.

        NaN for fewer than thirty of these.
        """
        _, of_one, of_other = np.intersect1d(one.draws, other.draws, assume_unique=True, return_indices=True)
        if len(of_one) < COMMON:
            return np.nan, np.nan
        apart = one.gain.information[of_one] - other.gain.information[of_other]
        return float(apart.mean()), float(apart.std(ddof=1) / np.sqrt(len(apart)))

    def alike(self) -> list[tuple[AdvisedTest, AdvisedTest]]:
        """The pairs of tests that cannot be told apart: their gains differ by less than two standard errors, or they have too few truths in common."""
        pairs = [(one, other) for row, one in enumerate(self.tests) for other in self.tests[row + 1 :]]
        return [pair for pair in pairs if not abs((found := self.difference(*pair))[0]) >= APART * found[1] > 0]

    def as_json(self) -> dict[str, Any]:
        """Plain data for other programs. Deviations are in the parameters' own units, pressures in Pa."""
        names = self.space.names
        return {
            "parameters": {name: {"unit": unit, "sd_now": float(sd)} for name, unit, sd in zip(names, self.space.units, self.deviations)},
            "draws": len(self.theta),
            "tests": [
                {
                    "name": each.name,
                    "kind": getattr(each.test.model, "kind", "python"),
                    "confining_pressure": getattr(each.test.model, "confining_pressure", None),
                    "control": each.test.control_name,
                    "to": float(each.test.at[-1]),
                    "observables": list(each.test.observables),
                    "information_gain": each.information,
                    "information_gain_standard_error": each.information_error,
                    "runs": each.runs,
                    "failures": len(each.failures),
                    "effective_samples": float(np.median(each.gain.effective_samples)),
                    "expected_sd": dict(zip(names, self.expected_deviations(each).tolist())),
                    "expected_sd_over_now": dict(zip(names, each.shares.tolist())),
                    "expected_sd_over_now_standard_error": dict(zip(names, each.share_errors.tolist())),
                    "packings_counted": each.not_studied is not None,
                    "packings_not_studied": list(each.not_studied or ()),
                }
                for each in self.tests
            ],
            "cannot_be_told_apart": [[one.name, other.name] for one, other in self.alike()],
            "not_judged": dict(self.not_judged),
            "remarks": list(self.remarks),
        }
