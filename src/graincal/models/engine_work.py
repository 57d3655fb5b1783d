"""Runs of a built-in test by graincal's own DEM engine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from graincal.data import Failure, Response
from graincal.dem.batch import Run, run_batch
from graincal.execution import Watch
from graincal.models.contact_laws import LAWS
from graincal.models.economy import DENSITY
from graincal.models.proportion import for_engine

if TYPE_CHECKING:
    from graincal.models.stress_path import StressPathTest

_NOTHING_RUN = {"steps": 0, "seconds": 0.0, "particle_steps": 0, "states": 0, "flagged": 0, "consolidation_flagged": 0}

_FAILURES = {
    "diverged": "the simulation diverged: a particle's motion ran away or a stress was not finite",
    "cell_too_small": "the periodic cell became too small for its largest particles",
    "out_of_steps": "the simulation reached its limit of {limit} steps",
    "out_of_memory": "the simulation found no memory for its neighbour lists",
}


@dataclass(frozen=True, eq=False)
class EngineWork:
    """What runs of a test on one packing, through the same states at rest (S,), share. A task's argument is theta (5,), in the order of the contact law's parameters."""

    test: StressPathTest
    states: NDArray[np.float64]
    key: str = field(default_factory=lambda: uuid4().hex)

    executor: ClassVar[None] = None
    own_process: ClassVar[bool] = False
    timeout: ClassVar[None] = None

    def prepare(self) -> None:
        """Nothing has to be."""

    def __call__(self, theta: NDArray[np.float64]) -> Response | Failure:
        return self.run(theta)

    def run(self, theta: NDArray[np.float64], stopped: Callable[[], bool] = lambda: False, watch: Watch | None = None) -> Response | Failure:
        """Simulate. A sample outside the bounds of the contact law is a Failure; where `watch` says so the run is stopped, and its states so far are the Response."""
        test = self.test
        for parameter, value in zip(LAWS[test.law].parameters, theta):
            if parameter.excludes(value):
                reason = f"{parameter.name} = {value:g} has no meaning, it must be a number {parameter.limits}{parameter.meant(value)}."
                return Failure("parameters", reason, _NOTHING_RUN)

        def watched(_: int, columns: Mapping[str, NDArray[np.float64]]) -> bool:
            # A run that can only fail is not gone on with: states that do not come to rest take most of the time of all runs in a box.
            if self._too_many_flagged(columns, len(self.states)):
                return True
            # Where too many of the states so far were not at rest they say nothing yet.
            return watch is not None and not self._too_many_flagged(columns, len(columns["flagged"])) and watch(test.response_of(columns, self.states))

        runs = run_batch(
            test.first_packing,
            [test.contact_law(theta)],
            test.stages_through(self.states),
            density=float(for_engine(DENSITY * test.scaling, test.unit_of_stress)),
            expected_steps=[1.0],
            threads=1,
            step_limit=test.step_limit,
            precision=test.setting("precision"),
            economy=test.economy,
            stopped=stopped,
            watch=watched,
        )
        return next((self._outcome(run) for run in runs), _STOPPED)

    def _outcome(self, run: Run) -> Response | Failure:
        test, flagged = self.test, int(run.columns["flagged"].sum())
        details = {"steps": run.steps, "seconds": run.seconds, "particle_steps": run.steps * test.first_packing.count}
        details |= {"states": len(run.columns["flagged"]), "flagged": flagged, "consolidation_flagged": int(run.consolidation_flagged)}
        if run.status not in ("finished", "stopped"):
            return Failure(run.status, _FAILURES[run.status].format(limit=test.step_limit) + f" (after {run.steps} steps).", details)
        if self._too_many_flagged(run.columns, len(self.states)):
            of = f"{details['states']}" if run.status == "finished" else f"the first {details['states']}"
            reason = f"{flagged} of {of} states were not at rest within their step limit, more than the share of {test.largest_flagged_share:g} of all {len(self.states)} that is allowed."
            return Failure("flagged", reason, details)
        if run.status == "stopped":
            details |= {"stopped": 1}
        return test.response_of(run.columns, self.states, details)

    def _too_many_flagged(self, recorded: Mapping[str, NDArray[np.float64]], of: int) -> bool:
        return bool(recorded["flagged"].sum() > self.test.largest_flagged_share * of)


_STOPPED = Failure("cancelled", "the simulation was stopped, for nobody waits for it any more.", _NOTHING_RUN)
