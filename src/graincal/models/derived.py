"""Parameters that a user's own program knows under other names, computed of those that are calibrated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from graincal.data import InputError, Samples
from graincal.notation.expression import CONSTANTS, Expression, NotAnExpression
from graincal.suggestion import did_you_mean


def check_derived(derived: Mapping[str, str], names: Sequence[str]) -> None:
    """Raise InputError where an expression is none, where it needs a name that is no parameter and no derived one before it, and where a name is a parameter's already."""
    known = list(names)
    for name, text in derived.items():
        if taken := [each for each in (*known, name) if each in CONSTANTS]:
            raise InputError(f"derived.{name}: {taken[0]} is a number in expressions, and another name for a parameter was expected.")
        try:
            needed = Expression(text).names
        except NotAnExpression as error:
            raise InputError(f'derived.{name} is "{text}", and an expression of {", ".join(known)} was expected: {error}.') from None
        if name in known:
            raise InputError(f"derived.{name} is the name of a parameter too, and another one was expected.")
        if unknown := [each for each in needed if each not in known]:
            raise InputError(
                f'derived.{name} is "{text}", which needs {unknown[0]}{did_you_mean(unknown[0], known)}, and some of {", ".join(known)} were expected.'
            )
        known.append(name)


def with_derived(samples: Samples, derived: Mapping[str, str]) -> Samples:
    """The samples with the derived parameters behind their own, in the order of these, (N, n + d); what overflows is infinite, what is undefined NaN."""
    values: dict[str, NDArray[np.float64]] = {name: samples.theta[:, column] for column, name in enumerate(samples.names)}
    for name, text in derived.items():
        values[name] = np.broadcast_to(np.asarray(Expression(text)(values), dtype=np.float64), (len(samples),))
    return Samples(samples.ids, np.stack(list(values.values()), axis=1), tuple(values)) if derived else samples
