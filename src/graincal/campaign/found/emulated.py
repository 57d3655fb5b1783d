"""What the emulated posterior says, computed once for a report: samples to draw, predictive bands, what each observable tells, modes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.campaign.found.answer import Answer
from graincal.campaign.found.by_emulators import ByEmulators
from graincal.campaign.found.record import Record
from graincal.campaign.found.trust import allows_discrepancy
from graincal.inference import Posterior
from graincal.inference.likelihood.error_model import measurement_errors
from graincal.inference.likelihood.likelihood import ReducedLikelihood
from graincal.inference.posterior.emulation import Emulation
from graincal.inference.posterior.likely_runs import LikelyRuns, log_likelihoods
from graincal.inference.posterior.sensitivity import evidence_of_half_ranges, under_one_likelihood, under_other_errors
from graincal.inference.sampling.groups import Group, find_groups
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.inference.sampling.proposal import systematic_resampling

UNSURE = 10.0
"""The log of an expected likelihood is so much above the log likelihood expected where the emulators do not know whether the parameters fit: their own doubt is several
times what the errors allow. On curves in closed form whose posterior has settled it is 1 to 4."""
DRAWN = 500
"""Samples of equal weight that stand for the posterior in figures and bands."""
_MOST_ALONE = 6
"""Pairs of experiment and observable up to which each is looked at alone: it takes some seconds a pair."""


@dataclass(frozen=True, eq=False)
class Bands:
    """Of one experiment, at the control values (K,) that are kept of its reference: 90 % intervals of the mean response, and of a measurement of it, each (2, K, J)."""

    control: NDArray[np.float64]
    response: NDArray[np.float64]
    measurement: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Drawn:
    """Of one experiment, at the control values (K,) that are kept of its reference: the mean response, and a measurement of it, at samples of the posterior, each (DRAWN, K, J)."""

    control: NDArray[np.float64]
    response: NDArray[np.float64]
    measurement: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Mode:
    """A group of parameter values that fit: its share of the probability, its centre and its most probable values (n,), and the least error ε of the runs in it."""

    share: float
    centre: NDArray[np.float64]
    best: NDArray[np.float64]
    error: float


class Emulated:
    """The emulated posterior of a result that has one. Everything is computed when it is first asked for; equal results give equal figures."""

    def __init__(self, result: Record, emulation: Emulation) -> None:
        self.result = result
        self.emulation = emulation
        self.posterior: Posterior = emulation.posterior

    @classmethod
    def of(cls, result: Record) -> Emulated | None:
        """None where the method is another, or nothing has been emulated."""
        emulation = result.emulation if result.has_posterior else None
        return cls(result, emulation) if emulation else None

    @property
    def known(self) -> ByEmulators:
        """What remarks rest on that takes emulators to know."""
        return ByEmulators(self.unsure, self.expected_error(), tuple(mode.share for mode in self.modes))

    @property
    def answer(self) -> Answer:
        """Where the parameters fit best as far as the emulators know."""
        answer = self.result.answer
        assert answer is not None, "there is one where something is emulated"
        return answer

    @property
    def fits(self) -> LikelyRuns:
        """The runs that fit about as well as the answer (`Result.fits_about_as_well`)."""
        fits = self.result.fits_about_as_well
        assert fits is not None, "there are some where something is emulated"
        return fits

    @cached_property
    def drawn(self) -> NDArray[np.intp]:
        """Rows of the posterior's samples, resampled to equal weights: (DRAWN,)."""
        return systematic_resampling(self.posterior.weights, DRAWN, np.random.default_rng(0))

    @property
    def theta(self) -> NDArray[np.float64]:
        """Samples of equal weight, (DRAWN, n)."""
        return self.posterior.samples[self.drawn]

    @cached_property
    def shrinkage(self) -> NDArray[np.float64]:
        """The posterior's standard deviation over the prior's, (n,)."""
        return self.posterior.relative_std(self.result.space)

    @cached_property
    def unsure(self) -> float:
        """The part of the probability that lies where the emulators do not know whether the parameters fit, in one experiment or another."""
        unit = self.result.space.to_unit(self.theta)
        with threadpool_limits(1):
            predicted = [(likelihood, emulator.predict(unit)) for likelihood, emulator in zip(self.emulation.likelihoods, self.emulation.emulators)]
            doubts = [likelihood(*response) - likelihood.expected(*response) for likelihood, response in predicted]
        return float(np.mean(np.max(doubts, axis=0) > UNSURE))

    @cached_property
    def predictive(self) -> tuple[Drawn, ...]:
        """For each experiment, at the samples `theta`."""
        rng, unit = np.random.default_rng(0), self.result.space.to_unit(self.theta)
        drawn = []
        with threadpool_limits(1):
            for emulator, likelihood, errors, scatters, reference in zip(
                self.emulation.emulators, self.emulation.likelihoods, self.result.knowledge.errors, self.result.knowledge.scatters, self.result.knowledge.kept
            ):
                names = reference.names
                mean, variance = emulator.predict(unit)
                response = emulator.curves(mean + np.sqrt(variance) * rng.standard_normal(mean.shape), len(names))
                # A hypothesis on the errors for each sample, as probable as the reference makes it.
                logs = likelihood.hypotheses(mean, variance) + likelihood.log_prior
                hypothesis = np.argmax(logs + rng.gumbel(size=logs.shape), axis=1)
                added = np.diag(emulator.added(scatters))
                sd = np.sqrt(np.array([np.diag(covariance) for covariance in errors.covariances])[hypothesis] + added)
                sd = np.swapaxes(sd.reshape(len(sd), len(names), -1), 1, 2)
                drawn.append(Drawn(reference.control, response, response + sd * rng.standard_normal(sd.shape)))
        return tuple(drawn)

    @cached_property
    def bands(self) -> tuple[Bands, ...]:
        """For each experiment, state by state."""
        levels = ((1 - PROBABILITY) / 2, (1 + PROBABILITY) / 2)
        return tuple(Bands(each.control, np.quantile(each.response, levels, axis=0), np.quantile(each.measurement, levels, axis=0)) for each in self.predictive)

    @cached_property
    def likely(self) -> NDArray[np.int64]:
        """Ids of the campaign's own runs that fit about as well as the answer (`Result.fits_about_as_well`); those that it was given to learn from have none."""
        result, known = self.result, self.result.knowledge
        logs = log_likelihoods(known.evaluations, known.kept, known.errors)[-len(result.ids) :]
        at_answer = np.isin(result.ids, self.answer.samples) & result.complete
        return result.ids[(logs >= self.fits.least) | at_answer]

    @cached_property
    def alone(self) -> dict[tuple[int, str], NDArray[np.float64]]:
        """For each experiment's number and observable: posterior over prior standard deviation (n,) with that one alone. Empty for a single one, or many."""
        pairs = [(number, name) for number, experiment in enumerate(self.result.experiments) for name in experiment.reference.names]
        if not 1 < len(pairs) <= _MOST_ALONE:
            return {}
        return {(number, name): self.result.derived(f"{name} alone, {number}", lambda: self._shrinkage_by(number, name)) for number, name in pairs}

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """The separate groups of values that fit, the most probable first; empty for a single one."""
        space = self.result.space
        groups = find_groups(space, Posterior(space.names, self.theta, np.full(DRAWN, 1 / DRAWN)))
        if not groups:
            return ()
        of_samples, of_runs = self._nearest(groups, self.posterior.samples), self._nearest(groups, self.result.samples)
        modes = []
        for number, group in enumerate(groups):
            likely = np.where((of_samples == number) & (self.posterior.weights > 0), self.emulation.explored.log_likelihood, -np.inf)
            errors = self.result.errors[(of_runs == number) & self.result.complete]
            modes.append(Mode(group.share, group.centre, self.posterior.samples[int(np.argmax(likely))], float(errors.min()) if errors.size else np.nan))
        return tuple(modes)

    @cached_property
    def evidence_of_half_ranges(self) -> float:
        """The log evidence with each range half as wide."""
        return evidence_of_half_ranges(self.posterior, self.result.space, self.emulation.log_evidence)

    @cached_property
    def without_discrepancy(self) -> Posterior | None:
        """The posterior if the model were able to reproduce the test; None where no discrepancy is allowed for anyway."""
        return self._without(discrepancy=False) if allows_discrepancy(self.result) else None

    @cached_property
    def without_packings(self) -> Posterior | None:
        """The posterior if all packings were alike; None where what they differ by is not known anyway."""
        return self._without(packings=False) if any(self.result.knowledge.packings) else None

    def _without(self, **terms: bool) -> Posterior:
        space = self.result.space

        def found() -> NDArray[np.float64]:
            """A row for each sample: its weight and its parameters."""
            known = self.result.knowledge
            posterior = under_other_errors(self.emulation, space, known.kept, known.scatters, known.errors_if(**terms), np.random.default_rng(0))
            return np.column_stack([posterior.weights, posterior.samples])

        rows = self.result.derived(f"without {', '.join(terms)}", found)
        return Posterior(space.names, rows[:, 1:], rows[:, 0])

    def expected_error(self) -> float:
        """The error ε (Eq. 6), percent, that measurement errors, and the scatter of runs where it counts, lead to on average.

        That of a Gaussian is 0.80 standard deviations at each state.
        """
        errors, shares = [], []
        for thinning, emulator, scatters in zip(self.result.knowledge.thinnings, self.emulation.emulators, self.result.knowledge.scatters):
            reference = thinning.whole
            scatter = np.diag(emulator.simulator) if scatters else np.zeros(thinning.kept.values.size)
            of_states = scatter.reshape(len(reference.names), -1)
            for error, values, share, added in zip(
                measurement_errors(reference), reference.values.T, reference.shares, np.repeat(of_states, thinning.counts, axis=1)
            ):
                sd = np.sqrt(error.absolute**2 + (error.relative * values) ** 2 + error.independent_variance() + added)
                errors.append(100 * np.sqrt(2 / np.pi) * sd.sum() / np.abs(values).sum())
                shares.append(share)
        return float(np.average(errors, weights=1 / np.array(shares)))

    def _nearest(self, groups: tuple[Group, ...], theta: NDArray[np.float64]) -> NDArray[np.intp]:
        space = self.result.space
        unit, centres = space.to_unit(theta), space.to_unit(np.array([group.centre for group in groups]))
        return np.argmin(np.sum((unit[:, None] - centres) ** 2, axis=2), axis=1)

    def _shrinkage_by(self, number: int, name: str) -> NDArray[np.float64]:
        both, emulator = self.result.knowledge.thinnings[number], self.emulation.emulators[number]
        place, states = both.whole.names.index(name), len(both.kept.control)
        rows = slice(place * states, (place + 1) * states)
        # With the error that it has beside the others.
        alone, errors = both.of_one(name, measurement_errors(both.whole)[place]), self.result.knowledge.errors[number]
        errors = replace(errors, covariances=errors.covariances[:, rows, rows])
        added = emulator.added(self.result.knowledge.scatters[number])[rows, rows]
        likelihood = ReducedLikelihood.of(alone.kept, errors, emulator.centre[rows], emulator.basis[rows], added)
        return under_one_likelihood(self.emulation, self.result.space, number, likelihood, np.random.default_rng(0)).relative_std(self.result.space)
