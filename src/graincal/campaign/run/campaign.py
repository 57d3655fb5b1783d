"""The loop of a calibration: ask the filter, evaluate, store, tell."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing, nullcontext
from pathlib import Path

from threadpoolctl import threadpool_limits

from graincal.campaign.asked.calibration import Calibration, Filter
from graincal.campaign.asked.file_names import file_name
from graincal.campaign.asked.limits import Limits
from graincal.campaign.file.forecast import Forecast
from graincal.campaign.found.replay import tell
from graincal.campaign.run.evaluations import Evaluations
from graincal.campaign.run.packing_study import study_packings
from graincal.campaign.stored.asked import OUT_OF_TIME, SPENT
from graincal.campaign.stored.curves import write_curve
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.listener import Listener
from graincal.campaign.stored.store import Store
from graincal.campaign.stored.trouble import FolderError
from graincal.data import Response, Samples
from graincal.inference import PosteriorFilter
from graincal.inference.emulator.side_by_side import by_at_most
from graincal.result import Result

CURVES = "curves"

OFTEN = 30.0
"""Seconds after which it is stored anew how long a campaign has run: what a kill loses of the clock."""


class Campaign:
    """A calibration as it runs, on a store that holds nothing of it yet, or some, or all.

    There is no other way to resume than to run: the filter is a function of what it is told, so it asks again for what the store holds, is told
    that, and goes on to what is waiting.
    """

    def __init__(self, calibration: Calibration, store: Store, listeners: Sequence[Listener] = ()) -> None:
        self.calibration = calibration
        self.store = store
        self.listeners = tuple(listeners)
        self._began, self._spent_before = time.monotonic(), float(store.meta(SPENT) or 0)
        self._noted = self._began

    def run(self) -> Result:
        """Go on to the end."""
        for listener in self.listeners:
            listener.begins(self.calibration)
        try:
            return self._to_the_end()
        finally:
            self.store.spend(self._spent)

    def _to_the_end(self) -> Result:
        filter = self.calibration.new_filter(self.store.look)
        self._say_what_is_expected(filter)
        # Evaluations in threads go on while a filter that asks for batches ahead limits the threads of linear algebra, which holds for all of a process: their last digits
        # would depend on when they run, if it did not hold all the time.
        in_turn = threadpool_limits(1) if getattr(filter, "ahead", 0) else nullcontext()
        # A machine that only hands out evaluations to others is not ours alone.
        threads = self.calibration.number_of_workers if self.calibration.place is None else 1
        with in_turn, by_at_most(threads), closing(self._evaluations()) as evaluations:
            return self._run(filter, evaluations)

    def _say_what_is_expected(self, filter: Filter) -> None:
        """To listeners, and to those who read the store, of a filter before its first round."""
        limits, known, stop = Limits.of(self.calibration, filter), self.calibration.known, self.calibration.stop
        settles = isinstance(filter, PosteriorFilter) and stop.posterior_shift is not False
        evaluations = Forecast.of(limits.first, len(known) if known else 0, limits.evaluations).evaluations if settles else None
        seconds = None if stop.hours is False else max(3600 * stop.hours - self._spent, 0.0)
        self.store.expect(evaluations, limits.evaluations, seconds)
        for listener in self.listeners:
            listener.expects(evaluations, limits.evaluations, seconds)

    def _run(self, filter: Filter, evaluations: Evaluations) -> Result:
        known = len(self.store.iterations())
        while not filter.finished:
            index = len(filter.iterations)
            samples = filter.under_way[0]
            evaluations.until_whole(index, filter.under_way, filter.early_stops)
            self._look_at_the_clock(filter, index, replayed=index < known)
            tell(filter, samples, self.store, self.calibration.experiments)
            if isinstance(filter, PosteriorFilter) and filter.places is not None:
                study_packings(filter, evaluations)
            learnt, looks = (Learnt.of(filter), filter.take_looks()) if isinstance(filter, PosteriorFilter) else (None, [])
            self.store.complete(filter.iterations[-1], learnt, looks)
            replayed = index < known
            if self.store.folder and (filter.finished or not replayed):
                write_curves(Result(self.store, self.calibration), self.store.folder / CURVES)
            for listener in self.listeners:
                listener.iteration_ends(filter.iterations[-1], replayed, learnt)
                if learnt and not learnt.predicts and not replayed:
                    listener.remark(
                        f"The emulator trained after batch {index} predicts runs no better than their mean does, and is dropped: the next batch, where one is asked for, is drawn where the runs themselves fit."
                    )
        by, because = filter.stopped_by, filter.stopped_because
        assert by is not None and because is not None, "a filter that has finished says why"
        self.store.stop(by, because)
        for listener in self.listeners:
            listener.stops(by, because)
        return Result(self.store, self.calibration)

    @property
    def _spent(self) -> float:
        """Seconds of wall time, of all sittings."""
        return self._spent_before + time.monotonic() - self._began

    def _look_at_the_clock(self, filter: Filter, index: int, replayed: bool) -> None:
        """Have the filter end with the iteration of this number where the time is over, or was when it ran."""
        hours = self.calibration.stop.hours
        if not replayed and hours is not False and self._spent >= 3600 * hours:
            self.store.keep(OUT_OF_TIME, str(index))
        if self.store.meta(OUT_OF_TIME) == str(index):
            filter.end("hours", f"the limit of {hours:g} hours is over")

    def fill(self, samples: Samples) -> None:
        """Evaluate samples as those of iteration 0, for no filter."""
        with closing(self._evaluations()) as evaluations:
            evaluations.until_whole(0, [samples])

    def _evaluations(self) -> Evaluations:
        return Evaluations(self.calibration, self.store, self.listeners, self._note_time)

    def _note_time(self) -> None:
        if time.monotonic() - self._noted > OFTEN:
            self._noted = time.monotonic()
            self.store.spend(self._spent)


def write_curves(result: Result, folder: Path) -> None:
    """The responses of the best and of the most probable sample, or the mean of the runs at the answer, a file for each experiment."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise FolderError.of(folder, error) from error
    for number, experiment in enumerate(result.experiments):
        curves = {}
        if result.best:
            curves["best"] = result.response(result.best.sample, number)
        if result.answer is None and result.most_probable:
            curves["most_probable"] = result.response(result.most_probable.sample, number)
        if result.answer and (mean := result.mean_response(result.answer, number)):
            curves["answer"] = mean
        for word, curve in curves.items():
            assert isinstance(curve, Response), "a sample with an error has responses"
            write_curve(folder / f"{file_name(experiment.name)}_{word}.csv", curve, experiment.reference.control_name)
