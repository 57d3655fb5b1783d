"""One test of a calibration: a model and the reference it is compared with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import Failure, InputError, Reference, Response, Samples
from graincal.execution import OneByOne
from graincal.models.interpolation import interpolate


class Model(Protocol):
    """Whatever evaluates samples.

    It may offer one_by_one(at), a `OneByOne`, to a campaign that asks for batches ahead; if it does not, `evaluate` is then called from several threads
    at once, each with one sample and one worker. And expected_lengths(samples), (N,): how the run lengths of samples compare with one another.
    """

    def evaluate(self, samples: Samples, at: ArrayLike, workers: int | None = None) -> Iterator[tuple[int, Response | Failure]]:
        """Evaluate each sample at the control values `at` and yield (row, Response or Failure) in order of completion.

        Closing the iterator stops what is under way. Raises InputError for what no sample can mend, also when there are no samples.
        """


@dataclass(frozen=True, eq=False)
class Experiment:
    """A test by its name, the model that runs it and the reference that was measured."""

    name: str
    model: Model
    reference: Reference

    @property
    def scatters(self) -> bool:
        """Whether the model's runs are spread over several packings, of which the laboratory's sample is one more."""
        return len(getattr(self.model, "packings", ())) > 1

    def evaluate(self, samples: Samples, workers: int | None = None) -> Iterator[tuple[int, Response | Failure]]:
        """Evaluate each sample and yield (row, outcome) in order of completion; a Response is on the reference's control, its observables finite."""
        outcomes = iter(self.model.evaluate(samples, at=self.reference.control, workers=workers))
        try:
            for row, outcome in outcomes:
                yield row, self._compared(outcome) if isinstance(outcome, Response) else outcome
        finally:
            # Not left to the garbage collector: simulations under way are stopped now.
            if hasattr(outcomes, "close"):
                outcomes.close()

    def one_by_one(self) -> OneByOne:
        """As `evaluate`, but of single samples and from any thread."""
        at, offered = self.reference.control, getattr(self.model, "one_by_one", None)
        each = offered(at) if offered else OneByOne(lambda sample: dict(self.model.evaluate(sample, at=at, workers=1))[0])

        def compared(sample: Samples) -> Response | Failure:
            outcome = each.evaluate(sample)
            return self._compared(outcome) if isinstance(outcome, Response) else outcome

        return replace(each, evaluate=compared)

    def expected_lengths(self, samples: Samples) -> NDArray[np.float64]:
        """How the run lengths of samples compare with one another, (N,): the same for all where the model does not know."""
        expected = getattr(self.model, "expected_lengths", None)
        return np.ones(len(samples)) if expected is None else expected(samples)

    def _compared(self, response: Response) -> Response | Failure:
        """The response at the reference's control values, or why it cannot be compared."""
        if missing := [name for name in self.reference.names if name not in response.values]:
            raise InputError(f'experiment "{self.name}": the model returns {", ".join(response.values)}, and the reference needs {", ".join(missing)} too.')
        outcome = interpolate(response, self.reference.control)
        for name in self.reference.names if isinstance(outcome, Response) else ():
            finite = np.isfinite(outcome.values[name])
            if not finite.all():
                where = f"{self.reference.control_name} {self.reference.control[np.argmin(finite)]:g}"
                return Failure("output", f"{name} is not finite at {where}.", outcome.details)
        return outcome
