"""A library read back: its runs, at their parameters."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from graincal.campaign.stored.store import Store
from graincal.data import Failure, InputError, Response, Samples


@dataclass(frozen=True, eq=False)
class Library:
    """The runs of a folder that `explore` filled: samples (N, n), and for each experiment the outcomes in their order, None where a run has not ended."""

    samples: Samples
    outcomes: tuple[tuple[Response | Failure | None, ...], ...]

    @classmethod
    def read(cls, folder: str | Path) -> Library:
        """Raises InputError for a folder that holds none."""
        with closing(Store.open(Path(folder))) as store:
            if not store.is_library:
                raise InputError(f"{folder}: this is a campaign, and a library of runs was expected.")
            samples = store.all_samples()
            return cls(samples, tuple(tuple(store.outcomes(samples.ids, number)) for number in range(len(store.description["experiments"]))))

    def responses(self, experiment: int = 0) -> list[Response]:
        """What the runs of an experiment that gave one returned."""
        return [outcome for outcome in self.outcomes[experiment] if isinstance(outcome, Response)]
