"""Who wants to know how a campaign goes: the log, the terminal, a notebook."""

from __future__ import annotations

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.stored.learnt import Learnt
from graincal.data import Failure, Response
from graincal.inference import Iteration


class Listener:
    """Hears of each step of a campaign. A listener overrides what it cares for."""

    def begins(self, calibration: Calibration) -> None:
        """A campaign begins, or goes on; that of a first look before the one that it is for."""

    def looks_first(self) -> None:
        """A first look is taken: the next campaign that begins is that, and the one after it the campaign that it is for."""

    def expects(self, evaluations: int | None, at_most: int | None, seconds: float | None) -> None:
        """The campaign that has begun comes to so many samples as most go, and to no more than `at_most`; no round begins after so many seconds from now. None for what is not known, or no limit. Said of no library."""

    def remark(self, text: str) -> None:
        """Something worth knowing, as a sentence."""

    def experiment_begins(self, iteration: int, experiment: str, waiting: int, samples: int) -> None:
        """An iteration's samples are evaluated in an experiment: those of its `samples` that are `waiting`."""

    def evaluates_beside(self, waiting: int) -> None:
        """So many evaluations are made beside those of the iteration under way, before it is complete: on other packings."""

    def evaluated(self, sample: int, experiment: str, outcome: Response | Failure) -> None:
        """One evaluation has ended, and is stored."""

    def iteration_ends(self, iteration: Iteration, replayed: bool, learnt: Learnt | None) -> None:
        """An iteration is complete; `replayed` if the store held all of it before. `learnt`: of the posterior, None for methods without one."""

    def stops(self, by: str, because: str) -> None:
        """The calibration is at its end."""
