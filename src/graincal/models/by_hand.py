"""A model whose runs somebody makes elsewhere: a licensed program, a machine that graincal does not reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from graincal.data import InputError, Samples
from graincal.execution import Task
from graincal.models.model import Model


@dataclass(frozen=True, eq=False)
class ByHandModel(Model):
    """Runs that a person makes: `graincal ask` says at which parameters, `graincal tell` takes what they gave. Nothing is run for it."""

    def tasks(self, samples: Samples, at: ArrayLike) -> Sequence[Task]:
        """Raise InputError for any sample: there is nothing that could run it."""
        if len(samples):
            raise InputError("its runs are made by hand, so that graincal cannot make them: those of a campaign are asked for by graincal ask, and told by graincal tell.")
        return []
