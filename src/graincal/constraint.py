"""What must hold between parameters, and what it leaves of the box of their ranges."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.errors import InputError
from graincal.notation.expression import CONSTANTS, Expression, NotAnExpression
from graincal.notation.printable import printable
from graincal.suggestion import did_you_mean

# The part of the box that is left is measured by so many independent quasi-random sequences, whose spread tells how well it is known: 1 % is two and a half standard errors of this size. Each grows from the
# first to the last of these lengths until that is reached, in pieces that fit into memory.
SEQUENCES, EXACT = 16, 0.004
FIRST, PIECE, LAST = 1 << 12, 1 << 17, 1 << 22

# Where none of so many points is left, or it is clear by then that even the longest sequences would miss that by this factor, there is no use in more.
NONE_OF, HOPELESS = 1 << 20, 1.5


@dataclass(frozen=True, eq=False)
class Constraint:
    """A condition on the columns of theta (N, n). columns: the column of each name in it that has a range; fixed: the values of the others."""

    condition: Expression
    columns: Mapping[str, int]
    fixed: Mapping[str, float]

    @classmethod
    def read(cls, source: str, names: Sequence[str], fixed: Mapping[str, float]) -> Constraint:
        """From a text over the names of theta's columns, and of parameters that are fixed. Raises InputError for what is none."""
        if not isinstance(source, str):
            raise InputError(f'constraint.require must be a condition such as "v0 < v1", not {printable(source, 60)}.')
        shown = f'constraint.require = "{printable(source, 100)}"'
        try:
            condition = Expression(source)
        except NotAnExpression as error:
            raise InputError(f"{shown}: {error}.") from None
        if taken := [name for name in (*names, *fixed) if name in CONSTANTS]:
            raise InputError(f"{shown}: {taken[0]} is a number in conditions, and another name for a parameter was expected.")
        if unknown := [name for name in condition.names if name not in names and name not in fixed]:
            known = (*names, *fixed)
            raise InputError(
                f"{shown} names {printable(unknown[0], 60)}, which is no parameter{did_you_mean(unknown[0], known)}; some of {', '.join(known)} were expected."
            )
        if not condition.compares:
            raise InputError(f'{shown} is no condition; a comparison such as "v0 < v1", or several with "and" and "or", was expected.')
        columns = {name: names.index(name) for name in condition.names if name in names}
        if not columns:
            raise InputError(f"{shown} names no parameter that has a range, and at least one was expected.")
        return cls(condition, columns, {name: fixed[name] for name in condition.names if name in fixed})

    @property
    def source(self) -> str:
        """The condition as it was written."""
        return self.condition.text

    def holds(self, theta: NDArray[np.float64]) -> NDArray[np.bool_]:
        """In which rows of theta (N, n) it holds, (N,). A comparison with what is undefined, as the root of a negative number, does not."""
        return self.condition({name: theta[:, column] for name, column in self.columns.items()} | dict(self.fixed))

    def at(self, columns: Mapping[str, int]) -> Constraint:
        """The same of a theta that has the names in other columns."""
        return Constraint(self.condition, columns, self.fixed)


@dataclass(frozen=True, eq=False)
class Left:
    """What constraints leave of the box. share: the part of its volume, to 1 %. deviation (n,): the standard deviation of each parameter there, in widths of the box. idle: constraints that hold at all points
    that were looked at."""

    share: float
    deviation: NDArray[np.float64]
    idle: tuple[str, ...]


def left(constraints: Sequence[Constraint], size: int, from_unit: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> Left:
    """What constraints leave of the unit cube of `size` dimensions, which `from_unit` maps onto the box. The same at every call.

    Raises InputError where they leave nothing, or so small a part that its volume cannot be known to 1 %.
    """
    from scipy.stats import qmc

    # Parameters that no constraint names are as they were, and the fewer dimensions, the evener the sequences.
    named = sorted({column for constraint in constraints for column in constraint.columns.values()})
    sequences = [qmc.Sobol(d=len(named), scramble=True, seed=np.random.default_rng([0, number])) for number in range(SEQUENCES)]
    met, kept, sums = np.zeros(len(constraints)), np.zeros(SEQUENCES), np.zeros((2, len(named)))
    length = 0
    while length < LAST:
        more = min(max(length, FIRST), PIECE)
        for number, sequence in enumerate(sequences):
            unit = np.full((more, size), 0.5)
            unit[:, named] = sequence.random(more)
            theta = from_unit(unit)
            each = np.array([constraint.holds(theta) for constraint in constraints])
            inside = unit[each.all(axis=0)][:, named]
            met += each.sum(axis=1)
            kept[number] += len(inside)
            sums += inside.sum(axis=0), (inside**2).sum(axis=0)
        length += more
        share, error = kept.mean() / length, kept.std(ddof=1) / np.sqrt(SEQUENCES) / length
        if error <= EXACT * share and share > 0:
            first, second = sums / kept.sum()
            deviation = np.full(size, 1 / np.sqrt(12))
            deviation[named] = np.sqrt(second - first**2)
            idle = tuple(constraint.source for constraint, count in zip(constraints, met) if count == SEQUENCES * length)
            return Left(float(share), deviation, idle)
        if share > 0 and error * np.sqrt(length / LAST) > HOPELESS * EXACT * share and SEQUENCES * length >= NONE_OF:
            break
        if not kept.any() and SEQUENCES * length >= NONE_OF:
            raise InputError(
                f"{_named(constraints)}: of {SEQUENCES * length:,} points that fill the ranges none is left; constraints that can be met within the ranges were expected."
            )
    raise InputError(
        f"{_named(constraints)}: they leave about {share:.1g} of the volume of the ranges, too little to know how much; ranges that hold less of what the constraints exclude were expected."
    )


def _named(constraints: Sequence[Constraint]) -> str:
    return "constraint.require = " + ", ".join(f'"{source}"' for source in dict.fromkeys(constraint.source for constraint in constraints))
