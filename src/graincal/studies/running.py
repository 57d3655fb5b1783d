"""Runs the work of studies, one piece after the other, and writes what they find."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from graincal.campaign import Listener
from graincal.data import InputError
from graincal.execution import number_of_workers
from graincal.notation.numbers import duration
from graincal.studies.made_with import alone_in, check_made_with
from graincal.studies.plan import Plan
from graincal.studies.settings import Setup
from graincal.studies.study import Done, Study
from graincal.studies.work import Work
from graincal.studies.writing import write

WORK = "work"
"""The folder under which each piece of work has its own."""

PARTICLE_STEPS = 1e7
"""A second and core, before anything was run here: on a common processor that does something else too."""


class Reproduction:
    """Studies as they are run, in a folder. say: hears a line of text now and then. listeners: of the campaigns."""

    def __init__(
        self,
        studies: Sequence[Study],
        setup: Setup,
        folder: Path,
        title: str,
        say: Callable[[str], None] = lambda text: None,
        listeners: Sequence[Listener] = (),
    ) -> None:
        self.studies, self.setup, self.folder, self.title, self.say, self.listeners = tuple(studies), setup, folder, title, say, listeners
        self.done = Done(folder / WORK)
        self.plan = Plan.of(studies, setup, self.done)
        self._failed: dict[str, str] = {}
        self.broken: dict[str, str] = {}
        """Of studies whose numbers could not be evaluated, why: a mistake in graincal."""

    def run(self) -> None:
        """To the end, the studies with the least left first. What cannot be run is said, and the others go on.

        Raises InputError where another process is running studies in the folder, and where this holds work of other data or another size.
        """
        with alone_in(self.done.folder):
            check_made_with(self.setup, self.done.folder)
            self._leave_out_other()
            self._say_plan()
            for study in sorted(self.studies, key=lambda study: self._left(self.plan.of_study[study.name])):
                waiting = self._waiting(study)
                for number, each in enumerate(waiting, 1):
                    self._go_on(each, f"{study.name}, {number} of {len(waiting)}: {each.title}; {duration(self._left(self.plan.all))} left of all")
                self.write()
            self.write()

    def write(self) -> Path:
        """Tables, figures and the page, of what is there."""
        path, broken = write(self.studies, self.setup, self.done, self.plan, self.folder, self.title, self._failed)
        for name, why in broken.items():
            if name not in self.broken:
                self.say(f"{name}: its numbers could not be evaluated, {why}")
        self.broken = broken
        return path

    def _go_on(self, work: Work, said: str) -> None:
        if before := [each.title for each in self.plan.after.get(work.name, ()) if not self.done.has(each)]:
            self._fail(work, f"it follows from {before[0]}, which is not at its end.")
            return
        self.say(said)
        try:
            work.go_on(self.done.folder_of(work), self.listeners)
        except InputError as error:
            self._fail(work, str(error))

    def _fail(self, work: Work, why: str) -> None:
        self._failed[work.name] = why
        self.say(f"{work.title} could not be run: {why}")

    def _leave_out_other(self) -> None:
        """Work at its end that is not what is asked for now, and what follows from it, is as if it were not there."""
        for each in self.plan.all:
            before = self.plan.after.get(each.name, ())
            if any(one.name in self.done.other for one in before):
                self._leave_out(each, "what it follows from is left out, and so is this.")
            elif self.done.has(each) and all(map(self.done.has, before)):
                try:
                    each.refuse_other(self.done.folder_of(each))
                except InputError as error:
                    self._leave_out(each, str(error))

    def _leave_out(self, work: Work, why: str) -> None:
        self.done.other.add(work.name)
        self._fail(work, why)

    def _waiting(self, study: Study) -> list[Work]:
        return [each for each in self.plan.of_study[study.name] if not self.done.has(each) and each.name not in self._failed]

    def _say_plan(self) -> None:
        skips = False
        for study in self.studies:
            for why, settings in self.plan.skipped_of(study.name).items():
                skips = True
                self.say(f"{study.name}: skipped, for {why}: {'; '.join(settings)}")
            work = self.plan.of_study[study.name]
            waiting = [each for each in work if not self.done.has(each)]
            left = f"{len(waiting)} of {len(work)} to run, about {duration(self._left(work))}" if waiting else f"all {len(work)} run"
            self.say(f"{study.name}: {left}")
        if skips:
            self.say(f"The data folder is {self.setup.data}; another one is named by --data.")

    def _left(self, work: Sequence[Work]) -> float:
        """Seconds that are left of some work, roughly."""
        waiting = [each for each in work if not self.done.has(each) and each.name not in self._failed]
        return sum(max(each.size / self._speed - each.seconds(self.done.folder_of(each)), 0.1 * each.size / self._speed) for each in waiting)

    @property
    def _speed(self) -> float:
        """Particle-steps of a forecast a second, by what was run."""
        ended = [each for each in self.plan.all if self.done.has(each)]
        seconds = sum(each.seconds(self.done.folder_of(each)) for each in ended)
        return sum(each.size for each in ended) / seconds if seconds > 1 else PARTICLE_STEPS * number_of_workers(self.setup.workers)
