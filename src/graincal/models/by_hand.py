"""A model whose runs somebody makes elsewhere: a licensed program, a machine that graincal does not reach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from graincal.data import InputError, Samples
from graincal.execution import Task
from graincal.models.derived import check_derived
from graincal.models.model import Model

if TYPE_CHECKING:
    from graincal.models.output import Output


@dataclass(frozen=True, eq=False)
class ByHandModel(Model):
    """Runs that a person makes: `graincal ask` says at which parameters, `graincal tell` takes what they gave. Nothing is run for it.

    output: which columns of a curve's file are which quantity; without one, the columns bear the quantities' names. derived: name -> expression of parameters, such as {"E": "10**log_E"}, of what is printed beside these.
    """

    output: Output | None = None
    derived: Mapping[str, str] = field(default_factory=dict)

    @property
    def returned(self) -> tuple[str, ...] | None:
        """The quantities that a file holds, the control among them; None where its header alone says that."""
        return None if self.output is None else tuple(self.output.columns)

    def check(self, at: ArrayLike, samples: Samples) -> None:
        """Raise InputError for derived parameters that cannot be computed."""
        check_derived(self.derived, samples.names)

    def tasks(self, samples: Samples, at: ArrayLike) -> Sequence[Task]:
        """Raise InputError for any sample: there is nothing that could run it."""
        if len(samples):
            raise InputError(
                "its runs are made by hand, so that graincal cannot make them: those of a campaign are asked for by graincal ask, and told by graincal tell."
            )
        return []

    def described(self) -> dict[str, Any]:
        """It as plain data (what JSON holds)."""
        return {"kind": "by-hand", "output": None if self.output is None else asdict(self.output), "derived": dict(self.derived)}

    @classmethod
    def restored(cls, described: Mapping[str, Any]) -> ByHandModel:
        """The model that was described."""
        from graincal.models.output import Output

        return cls(None if described["output"] is None else Output.restored(described["output"]), described["derived"])
