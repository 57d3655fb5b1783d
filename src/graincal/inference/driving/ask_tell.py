"""What every filter is to whoever drives it: it is asked for samples, and told what became of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import Reference, Samples
from graincal.inference.driving.batch import Batch, Batches
from graincal.inference.driving.iteration import Iteration
from graincal.inference.likelihood.early_stop import EarlyStop
from graincal.inference.likelihood.thinning import Thinning


class AskTellFilter(ABC):
    """A filter that asks for samples in batches.

    A subclass puts batches into `_batches`, those under way, and says in `_complete_batch` what follows of the earliest, once it is complete: it appends
    to `_iterations`, and puts the criteria that are met, each with a clause that says it, into `_stops`.
    """

    thinnings: tuple[Thinning, ...]
    _batches: Batches
    _iterations: list[Iteration]
    _stops: dict[str, str]
    _ended: dict[str, str] = {}

    def end(self, by: str, because: str) -> None:
        """Ask for no further iteration once the one under way is complete, by a limit that a filter cannot see, such as one in time; because: a clause that says it."""
        self._ended = {by: because}

    @abstractmethod
    def _complete_batch(self, batch: Batch) -> None:
        """All samples of the batch and of all before it have been told: weigh them, and ask for others or finish."""

    def ask(self) -> Samples:
        """All samples that have not been told, of all iterations under way, the earliest first; none when finished. Asking changes nothing."""
        return self._batches.untold()

    def tell(
        self,
        samples: Samples,
        responses: NDArray[np.float64] | Sequence[NDArray[np.float64]],
        failed: ArrayLike | None = None,
        infeasible: ArrayLike | None = None,
        stopped: ArrayLike | None = None,
    ) -> None:
        """Say what the model returned for some of the samples asked, in any order. Iterations are completed in order, by the last one told of each.

        `responses` is x (N, T, J) at the reference's own control values, in the order of its observables; with several experiments, a sequence of
        such arrays. `failed` (N,) marks evaluations without a usable response; their rows are not looked at. A row with a value that is not
        finite, in any experiment, counts as failed too. `infeasible` (N,) marks failures whose parameters are impossible: their likelihood is zero,
        where to a posterior other failures say nothing of the parameters. By the paper's method any failure has weight zero. `stopped` (N,) marks evaluations
        that ended early because `early_stops` said so, whose responses are NaN from some state on (all of them, in an experiment that was left out).
        Raises InputError, and stores nothing, for samples that were not asked or already told, for other parameters under the id of one that
        was asked, and for arrays of another shape.
        """
        self._batches.tell(samples, responses, failed, infeasible, stopped)
        self._complete_batches()

    def _complete_batches(self) -> None:
        while batch := self._batches.take_complete():
            self._complete_batch(batch)

    @property
    def kept(self) -> tuple[Reference, ...]:
        """The references at the states that are kept of them, by which samples are weighed; errors are of all rows."""
        return tuple(thinning.kept for thinning in self.thinnings)

    @property
    def finished(self) -> bool:
        """Whether there is nothing more to ask."""
        return bool(self._stops)

    @property
    def stopped_by(self) -> str | None:
        """The criterion that ended the calibration, None while it runs: a field of `Stop`, the first where several are met; or what kept it from going
        on, "failures" (no response to learn from), "effective_sample_size" (no weights meet it), "proposal" (too little of it lies in the box)."""
        return next(iter(self._stops), None) if self.finished else None

    @property
    def stopped_because(self) -> str | None:
        """All criteria met, as a sentence; None while it runs."""
        if not self.finished:
            return None
        reasons = "; ".join(self._stops.values())
        return reasons[0].upper() + reasons[1:] + "."

    @property
    def under_way(self) -> tuple[Samples, ...]:
        """All samples of each iteration that is asked for and not complete, told or not: the first is that of number `len(iterations)`."""
        return tuple(batch.samples for batch in self._batches)

    @property
    def early_stops(self) -> tuple[EarlyStop | None, ...]:
        """For each of `under_way`, when its runs may be stopped; None for never."""
        return tuple(batch.early_stop for batch in self._batches)

    @property
    def iterations(self) -> tuple[Iteration, ...]:
        """The iterations that are complete."""
        return tuple(self._iterations)
