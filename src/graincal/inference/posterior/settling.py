"""When a posterior is known: what the emulators do not know moves it by little, and fresh runs at draws from it fit as it says."""

from __future__ import annotations

from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from graincal.inference.posterior.emulation import Emulation

# Fresh runs at draws from the posterior, before it is said to have settled: what they leave of its probability, as a factor, and how far they move it in terms of what is enough.
# An emulator that is more careful than it need be is proved right by more; one that holds places possible that are not, by less.
FRESH, CONFIRMED, MOVED = 20, (0.5, 3.0), 2.0

# Of the posterior's probability, what may lie where runs fail or parameters are infeasible, for it to be known.
MOST_LOST = 0.5


class Settling:
    """Follows a calibration to where its posterior has settled.

    enough: `Stop.posterior_shift`. confirmed: by what factor the latest fresh runs changed their places' probability, on the mean; NaN before there are any. settled: whether they confirmed it.
    """

    def __init__(self, enough: float | Literal[False]) -> None:
        self._enough = enough
        self._fresh: tuple[int, Emulation] | None = None  # the number of their batch, and what was known before it
        self._tried = False  # whether the latest batch was of fresh runs
        self.confirmed = np.nan
        self.settled = False

    def calm(self, emulation: Emulation | None) -> bool:
        """Whether what the emulators do not know moves the posterior by little, and most of it lies where runs succeed."""
        return (
            self._enough is not False and emulation is not None and emulation.predicts and emulation.doubt.most <= self._enough and emulation.lost <= MOST_LOST
        )

    def wants_fresh_runs(self, emulation: Emulation | None) -> bool:
        """Whether the next batch is to be of fresh runs."""
        return self.calm(emulation) and self._fresh is None and not self._tried

    def ask_fresh_runs(self, batch: int, emulation: Emulation) -> None:
        """The batch of this number is of fresh runs, at draws from this posterior."""
        self._fresh = batch, emulation

    def is_fresh(self, batch: int) -> bool:
        """Whether the batch of this number was of fresh runs."""
        return self._fresh is not None and self._fresh[0] == batch

    def learn(self) -> None:
        """A batch of other runs was learnt from."""
        self._tried = False

    @property
    def before_fresh(self) -> Emulation:
        """What was known before the fresh runs."""
        assert self._fresh is not None, "fresh runs are learnt from once they were asked for"
        return self._fresh[1]

    def confirm(self, changed: NDArray[np.float64], emulation: Emulation, shift: float) -> None:
        """Fresh runs were learnt from: they changed the log likelihood at their places by so much (M,), and moved the posterior by `shift`. Whether they fit as it said."""
        self.confirmed = float(np.exp(scipy.special.logsumexp(changed) - np.log(len(changed))))
        self._fresh, self._tried = None, True
        self.settled = self.calm(emulation) and shift <= MOVED * (self._enough or 0) and CONFIRMED[0] <= self.confirmed <= CONFIRMED[1]
