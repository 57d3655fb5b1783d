"""How far the answer is from what was recorded beside the observables and not fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.found.repeated import Repeated
from graincal.notation import numbers
from graincal.notation.quantities import quantity

if TYPE_CHECKING:
    from graincal.campaign.found.record import Record


@dataclass(frozen=True, eq=False)
class RecordedError(Repeated):
    """Of one recorded quantity of an experiment: errors (R,), percent (Hartmann, Cheng, Thornton 2022, Eq. 5), of the R runs of `of`; NaN for a failure and where a value is not finite.

    of: "answer" (all runs there), "most probable sample" or "best sample" (that one).
    """

    experiment: str
    name: str
    of: str
    errors: NDArray[np.float64]

    def as_json(self) -> dict[str, Any]:
        """The error as `graincal status --json` has it."""
        plain = [float(error) if np.isfinite(error) else None for error in (*self.errors, self.mean, self.spread)]
        return {"experiment": self.experiment, "observable": self.name, "of": self.of, "errors": plain[:-2], "mean": plain[-2], "spread": plain[-1]}


def recorded_of_answer(result: Record) -> tuple[RecordedError, ...]:
    """Of all that was recorded and not fitted: by the runs at the answer, or by the most probable sample of the paper's method; by the best sample where there is neither yet. None where all failed."""
    if not result.recorded_names:
        return ()
    answer = result.answer
    if answer and np.isfinite(answer.errors).any():
        of, ids = "answer", answer.samples.tolist()
    elif most_probable := None if result.has_posterior else result.most_probable:
        of, ids = "most probable sample", [most_probable.sample]
    elif best := result.best:
        of, ids = "best sample", [best.sample]
    else:
        return ()
    return tuple(RecordedError(experiment, name, of, errors) for (experiment, name), errors in zip(result.recorded_names, result.recorded_errors_of(ids).T))


def in_words(recorded: Sequence[RecordedError]) -> str:
    """The errors in a sentence, in markup; nothing where there are none."""
    if not recorded:
        return ""
    several = len({each.experiment for each in recorded}) > 1
    listed = ", ".join(f"{f'{each.experiment}: ' * several}{quantity(each.name).label} {in_percent(each)}" for each in recorded)
    by = "runs at the answer" if recorded[0].of == "answer" else recorded[0].of
    return f"Recorded and not fitted, with the error of the {by} (Eq. 5): {listed}."


def in_percent(recorded: RecordedError) -> str:
    """The mean of its errors, with what they scatter by: `12.3 ± 0.4 %`."""
    return f"{numbers.repeated(recorded.mean, recorded.spread)} %"
