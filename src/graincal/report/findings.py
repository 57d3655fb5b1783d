"""What a posterior says of each parameter, and how it is said."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graincal.data import ParameterSpace
from graincal.inference import Iteration, Posterior
from graincal.report import numbers
from graincal.report.chance import narrowing_by_chance
from graincal.report.quantities import Quantity, parameters

IDENTIFIED, NOT_IDENTIFIED = 1 / 3, 2 / 3
"""Spreads (see `Finding.spread`) up to which a parameter is identified, and from which on it is not."""
PROBABILITY = 0.9
"""Of the intervals."""
MOST = f"{100 * PROBABILITY:.0f} % of the weight"
STRONG_CORRELATION = 0.7
FEW = 10
"""Samples of equal weight, below which correlations say nothing."""


@dataclass(frozen=True)
class Finding:
    """What is known of one parameter: moments of its weighted samples, and the range it was sought in.

    low, high: the central interval that holds 90 % of the weight. by_chance: the spread that a parameter without effect may narrow to.
    """

    name: str
    quantity: Quantity
    range: tuple[float, float]
    mean: float
    std: float
    low: float
    high: float
    by_chance: float

    @property
    def spread(self) -> float:
        """The standard deviation over that of values spread evenly over the range; near 1 nothing was learnt."""
        return self.std * math.sqrt(12) / (self.range[1] - self.range[0])

    @property
    def verdict(self) -> str:
        """One of "identified", "weakly identified", "not identified", or "uncertain" where chance may have narrowed the samples."""
        if self.spread >= NOT_IDENTIFIED:
            return "not identified"
        if self.spread >= self.by_chance:
            return "uncertain"
        return "identified" if self.spread <= IDENTIFIED else "weakly identified"

    @property
    def reached_ends(self) -> tuple[float, ...]:
        """The ends of the range that the interval reaches, to within a hundredth of the range, of a parameter that is not left open anyway."""
        if self.verdict in ("not identified", "uncertain"):
            return ()
        near = 0.01 * (self.range[1] - self.range[0])
        return tuple(end for end, reached in zip(self.range, (self.low, self.high)) if abs(reached - end) <= near)

    def sentences(self) -> tuple[str, ...]:
        """The finding in words, in markup."""
        label, unit = self.quantity.label, _unit(self.quantity)
        interval = numbers.between(self.low, self.high) + unit
        if self.verdict == "not identified":
            said = [f"{label} is not identified: {interval} fit about equally."]
        elif self.verdict == "uncertain":
            said = [f"{label} = {numbers.estimate(self.mean, self.std)}{unit}, perhaps: chance alone may narrow samples as far."]
        elif self.verdict == "weakly identified":
            said = [f"{label} = {numbers.estimate(self.mean, self.std)}{unit}, weakly identified: {MOST} lies from {numbers.between(self.low, self.high)}."]
        else:
            said = [f"{label} = {numbers.estimate(self.mean, self.std)}{unit}{self._in_plain_units()}."]
        if self.reached_ends:
            ends = " and ".join(numbers.short(end) for end in self.reached_ends)
            said.append(f"Its interval reaches the end of its range at {ends}{unit}: where values beyond make sense, widen it.")
        return tuple(said)

    def _in_plain_units(self) -> str:
        """For a logarithm of a quantity with a unit, the quantity itself."""
        prefix, _, unit = self.quantity.unit.partition(" ")
        if prefix != "log_{10}" or not unit or not self.quantity.label.startswith("log "):
            return ""
        power = 3 * math.floor(self.mean / 3)
        prefixes = {3: "k", 6: "M", 9: "G", -3: "m", -6: "µ", 0: ""}
        if power not in prefixes:
            return ""
        low, high = (10 ** (self.mean + sign * self.std - power) for sign in (-1, 1))
        return f", so {self.quantity.label[4:]} from {numbers.between(low, high)} {prefixes[power]}{unit}"


def find(space: ParameterSpace, iterations: Sequence[Iteration]) -> tuple[Finding, ...]:
    """What the iterations of a filter say of each parameter; nothing where none has weights."""
    weighted = [iteration for iteration in iterations if not iteration.unweighted]
    return judge(space, weighted[-1].posterior, narrowing_by_chance(weighted)) if weighted else ()


def judge(space: ParameterSpace, posterior: Posterior, by_chance: float) -> tuple[Finding, ...]:
    """What a posterior says of each parameter, where one without effect may narrow to the spread `by_chance`."""
    mean, std, (low, high) = posterior.mean(), posterior.std(), posterior.interval(PROBABILITY)
    return tuple(
        Finding(name, quantity, (float(space.low[k]), float(space.high[k])), float(mean[k]), float(std[k]), float(low[k]), float(high[k]), by_chance)
        for k, (name, quantity) in enumerate(zip(space.names, parameters(space)))
    )


def rule(findings: Sequence[Finding]) -> str:
    """The rule of the verdicts, for readers."""
    chance = findings[0].by_chance
    if chance < 0.005:
        narrowing = "in these iterations, of so few samples with weight, to next to nothing, so that nearly all that is not beyond two thirds is called uncertain."
    else:
        narrowing = f"in these iterations seldom to below {chance:.2f} of that sd, and what is not below is called uncertain."
    return (
        "“±” is one standard deviation (sd) of the weighted samples. The verdicts compare it with the sd of values spread evenly over the range (its width "
        "over √12): a parameter is called identified up to a third of that, weakly identified up to two thirds, and not identified beyond. Samples also narrow "
        f"by chance, along parameters without any effect: {narrowing} Intervals hold {MOST}."
    )


def trade_offs(space: ParameterSpace, posterior: Posterior) -> str:
    """A sentence on the pairs of parameters that are strongly correlated, the strongest first; empty without."""
    labels = [quantity.label for quantity in parameters(space)]
    correlation = posterior.correlation()
    strong = max(STRONG_CORRELATION, telling_correlation(posterior))
    pairs = [(float(correlation[i, j]), i, j) for i in range(space.size) for j in range(i) if abs(correlation[i, j]) >= strong]
    if not pairs:
        return ""
    listed = ", ".join(f"{labels[j]} and {labels[i]} ({signed(r)})" for r, i, j in sorted(pairs, key=lambda pair: -abs(pair[0])))
    return f"Strongly correlated: {listed}. What such a pair shares is known better than either of the two alone."


def telling_correlation(posterior: Posterior) -> float:
    """The correlation, up or down, from which it is hardly chance: those of unrelated values scatter by 1 / √M for M samples. Infinite for few."""
    carried = effective_samples(posterior)
    return 2.5 / math.sqrt(carried) if carried >= FEW else math.inf


def effective_samples(posterior: Posterior) -> float:
    """The number of samples of equal weight that would carry as much: 1 / sum w²."""
    return float(1 / np.sum(posterior.weights**2))


def _unit(quantity: Quantity) -> str:
    return f" {quantity.unit}" if quantity.unit not in ("", "-") else ""


def signed(r: float) -> str:
    """A correlation as it is shown."""
    return f"{r:+.2f}".replace("-", "−")
