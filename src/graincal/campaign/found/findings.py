"""What the samples say of each parameter, and how it is said."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from graincal.data import ParameterSpace
from graincal.inference import Iteration, Posterior
from graincal.inference.iterative.advice import OPTIMAL_ERROR
from graincal.inference.iterative.close_fits import MARGIN, CloseFits, close_fits
from graincal.inference.iterative.narrowing import narrowing_by_chance
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.notation import numbers
from graincal.notation.quantities import Quantity, parameters
from graincal.parameter_space import LINEAR, LOG

NARROWED, NOT_IDENTIFIED = 1 / 3, 2 / 3
"""Parts of the range (see `Finding.extent`) up to which a parameter is narrowed, and from which on it is not identified."""
MOST = f"{100 * PROBABILITY:.0f} % of the weight"
STRONG_CORRELATION = 0.7
FEW = 10
"""Samples of equal weight, below which correlations say nothing."""


@dataclass(frozen=True)
class Finding:
    """What is known of one parameter: moments of its weighted samples, values that fit about as well, and the range it was sought in.

    low, high: the central interval that holds 90 % of the weight. close: the ends of the values that fit about as well (close_fits.py), and outlined:
    whether samples enough do so for these to be a range.
    spread: the weighted samples' standard deviation over that of the prior; near 1 nothing was learnt.
    by_chance: the spread that a parameter without effect may narrow to. truth: its value, where that is known. scale: in what the prior is uniform, the value or its logarithm: parts of the range are parts of that.
    """

    name: str
    quantity: Quantity
    range: tuple[float, float]
    mean: float
    std: float
    low: float
    high: float
    close: tuple[float, float]
    spread: float
    by_chance: float
    truth: float | None = None
    outlined: bool = True
    scale: str = LINEAR

    @property
    def extent(self) -> float:
        """The part of the range that is left: that of the values that fit about as well, or the spread where it is larger."""
        return max(self.spread, self._part(*self.close))

    def _part(self, low: float, high: float) -> float:
        """What part of the range lies between two values."""
        low, high, first, last = (math.log(end) if self.scale == LOG else end for end in (low, high, *self.range))
        return (high - low) / (last - first)

    @property
    def verdict(self) -> str:
        """One of "narrowed", "weakly narrowed", "not identified", or "uncertain" where chance may have narrowed the samples.

        Nothing is called identified: samples that are drawn ever closer about the ones before do not show that other values fit worse.
        """
        if self.extent >= NOT_IDENTIFIED:
            return "not identified"
        if self.spread >= self.by_chance:
            return "uncertain"
        return "narrowed" if self.extent <= NARROWED else "weakly narrowed"

    @property
    def astray(self) -> bool:
        """Whether the samples narrowed, and the known value lies outside of all that they cover."""
        if self.truth is None or self.verdict not in ("narrowed", "weakly narrowed"):
            return False
        ranges = [(self.low, self.high), *([self.close] if self.outlined else [])]
        return not any(low <= self.truth <= high for low, high in ranges)

    @property
    def widest(self) -> tuple[float, float]:
        """The wider of the two ranges, of the weight and of the close fits where these outline one."""
        if not self.outlined:
            return self.low, self.high
        return max(self.close, (self.low, self.high), key=lambda ends: self._part(*ends))

    @property
    def reached_ends(self) -> tuple[float, ...]:
        """The ends of the range that the wider range reaches, to within a hundredth, of a parameter that is not left open anyway."""
        if self.verdict in ("not identified", "uncertain"):
            return ()
        return tuple(end for end, reached in zip(self.range, self.widest) if abs(self._part(reached, end)) <= 0.01)

    def sentences(self) -> tuple[str, ...]:
        """The finding in words, in markup."""
        label, unit = self.quantity.label, self.quantity.behind
        holds = "at least fit about as well" if self.outlined and self.widest == self.close else f"hold {MOST}"
        values = f"{numbers.between(*self.widest)}{unit}{self.quantity.without_log(*self.widest)} {holds}"
        if not self.outlined and self.close[1] - self.close[0] > self.high - self.low:
            values += f", and the few samples that fit about as well lie from {numbers.between(*self.close)}{unit}"
        estimate = f"{numbers.estimate(self.mean, self.std)}{unit}"
        if self.verdict == "not identified":
            said = [f"{label} is not identified: {values}."]
        elif self.verdict == "uncertain":
            said = [
                f"{label} is uncertain: {values}. The weighted samples are at {estimate}, but those of a parameter without any effect may lie as close together."
            ]
        else:
            said = [f"{label} is {self.verdict}: {values}; the weighted samples are at {estimate}."]
        if self.reached_ends:
            ends = " and ".join(numbers.short(end) for end in self.reached_ends)
            said.append(f"These values reach the end of its range at {ends}{unit}: where values beyond make sense, widen it.")
        if self.truth is not None:
            said.append(self._beside(self.truth))
        return tuple(said)

    def _beside(self, value: float) -> str:
        """Whether each of the ranges covers the known value, and what it means where the samples narrowed about another."""
        interval = f"the {100 * PROBABILITY:.0f} % interval ({numbers.between(self.low, self.high)})"
        truth = f"The truth, {numbers.short(value)}{self.quantity.behind},"
        if self.astray:
            where = f"{interval} and the values that fit about as well" if self.outlined else interval
            return (
                f"{truth} lies outside {where}: the samples gathered about the first values that fitted, and these were others. Narrowed does not mean right."
            )
        if not self.outlined:
            return f"{truth} lies {'in' if self.low <= value <= self.high else 'outside'} {interval}."
        weighted, close = (low <= value <= high for low, high in ((self.low, self.high), self.close))
        said = {
            (True, True): "lies in {} and among the values that fit about as well",
            (True, False): "lies in {}, but not among the values that fit about as well",
            (False, True): "lies outside {}, but among the values that fit about as well",
            (False, False): "lies outside {} and the values that fit about as well",
        }[weighted, close]
        return f"{truth} {said.format(interval)}."


def find(space: ParameterSpace, iterations: Sequence[Iteration], truth: Mapping[str, float] = MappingProxyType({})) -> tuple[Finding, ...]:
    """What the iterations of a filter say of each parameter, beside the known values of some; nothing where none has weights."""
    weighted = [iteration for iteration in iterations if not iteration.unweighted]
    close = close_fits(iterations)
    return judge(space, weighted[-1].posterior, close, narrowing_by_chance(weighted), truth) if weighted and close is not None else ()


def judge(
    space: ParameterSpace, posterior: Posterior, close: CloseFits, by_chance: float, truth: Mapping[str, float] = MappingProxyType({})
) -> tuple[Finding, ...]:
    """What a posterior and the close fits say of each parameter, where one without effect may narrow to the spread `by_chance`."""
    mean, std, spread, (low, high) = posterior.mean(), posterior.std(), posterior.relative_std(space), posterior.interval(PROBABILITY)
    return tuple(
        Finding(
            name,
            quantity,
            range=(float(space.low[k]), float(space.high[k])),
            mean=float(mean[k]),
            std=float(std[k]),
            low=float(low[k]),
            high=float(high[k]),
            close=(float(close.low[k]), float(close.high[k])),
            spread=float(spread[k]),
            by_chance=by_chance,
            truth=truth.get(name),
            outlined=close.enough,
            scale=space.scales[k],
        )
        for k, (name, quantity) in enumerate(zip(space.names, parameters(space)))
    )


def legend(close: CloseFits, iteration: int) -> str:
    """What the two ranges in the sentences of findings are, for readers."""
    few = (
        ""
        if close.enough
        else f" Only {numbers.count(close.count, 'sample')} did so far, too few to outline a range, so that what holds {MOST} is given instead."
    )
    return (
        f"Values “fit about as well” where samples that have them come to an error ε of at most {numbers.percent(close.limit)}, {MARGIN:g} percentage points above the smallest.{few} "
        f"“±” is one standard deviation (sd) of the weighted samples of iteration {iteration}, as the paper reports it: "
        "it shrinks with every iteration, whatever the noise of the data."
    )


def rule(findings: Sequence[Finding], close: CloseFits) -> str:
    """The rule of the verdicts, for readers."""
    chance = findings[0].by_chance
    if chance < 0.005:
        narrowing = "In these iterations so few samples carry weight that this may be next to nothing, and nearly all that is not open is called uncertain."
    else:
        narrowing = f"In these iterations such a parameter may shrink to {numbers.percent(100 * chance, 2)} of the spread that it began with."
    best = close.limit - MARGIN
    better = "" if best < OPTIMAL_ERROR else f" Better fits than the best so far, of {numbers.percent(best)}, may lie outside of these ranges altogether."
    return (
        "How a parameter is judged: by the part of its range that is still open. That is the part over which values fit about as well, or over which the weighted "
        "samples spread, whichever is larger. Up to a third is called narrowed, up to two thirds weakly narrowed, more not identified. "
        "Uncertain is a parameter whose samples lie no closer together than those of one that changes nothing in the response: "
        f"samples are drawn about those before, and so shrink even then. {narrowing} "
        "No parameter is called identified, because few values were tried away from the first good ones. For the same reason more values may fit than are listed."
        f"{better} The margin of {MARGIN:g} percentage points is what two runs of the same parameters may differ by in a long shear; in short ones they differ by less."
    )


def trade_offs(space: ParameterSpace, posterior: Posterior) -> str:
    """A sentence on the pairs of parameters that are strongly correlated, the strongest first; empty without."""
    labels = [quantity.label for quantity in parameters(space)]
    correlation = posterior.correlation()
    strong = max(STRONG_CORRELATION, telling_correlation(posterior))
    pairs = [(float(correlation[i, j]), i, j) for i in range(space.size) for j in range(i) if abs(correlation[i, j]) >= strong]
    if not pairs:
        return ""
    listed = ", ".join(f"{labels[j]} and {labels[i]} ({numbers.signed(r)})" for r, i, j in sorted(pairs, key=lambda pair: -abs(pair[0])))
    return f"Strongly correlated: {listed}. What such a pair shares is known better than either of the two alone."


def telling_correlation(posterior: Posterior) -> float:
    """The correlation, up or down, from which it is hardly chance: those of unrelated values scatter by 1 / √M for M samples. Infinite for few."""
    carried = effective_samples(posterior)
    return 2.5 / math.sqrt(carried) if carried >= FEW else math.inf


def effective_samples(posterior: Posterior) -> float:
    """The number of samples of equal weight that would carry as much: 1 / sum w²."""
    return float(1 / np.sum(posterior.weights**2))
