"""Where a campaign's evaluations run, if not in workers of graincal's own: no part of what was asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

PARSL = "parsl"


@dataclass(frozen=True)
class Place:
    """As [run] of a calibration file says it.

    executor: "parsl", or the function that gives a `concurrent.futures.Executor`, as "module:function". blocks: the keys of [run.parsl]. folder: where the function's module is looked for before the usual places.
    """

    executor: str
    blocks: Mapping[str, Any] = field(default_factory=dict)
    folder: str | None = None

    def as_json(self) -> dict[str, Any]:
        """Plain data, from which `Place(**data)` makes the same."""
        return asdict(self)

    def __str__(self) -> str:
        """For the middle of a sentence."""
        return f"Parsl ({self.blocks['provider']})" if self.executor == PARSL else f"the executor of {self.executor}"
