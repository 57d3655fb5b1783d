"""One test of a calibration: a model and the reference it is compared with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.data import Failure, InputError, Reference, Response, Samples
from graincal.execution import OneByOne
from graincal.models.interpolation import interpolate


Hopeless = Callable[[int, NDArray[np.float64]], bool]


class Model(Protocol):
    """Whatever evaluates samples.

    It may offer one_by_one(at), a `OneByOne`, to a campaign that asks for batches ahead; if it does not, `evaluate` is then called from several threads
    at once, each with one sample and one worker. And expected_lengths(samples), (N,): how the run lengths of samples compare with one another. If its
    `can_be_watched` is true, both take a further watch(id, response), which is shown the first of a sample's states, at the first of the control values `at`, and
    stops its run by returning True: then they are its Response, with details["stopped"] = 1.
    """

    def evaluate(self, samples: Samples, at: ArrayLike, workers: int | None = None) -> Iterator[tuple[int, Response | Failure]]:
        """Evaluate each sample at the control values `at` and yield (row, Response or Failure) in order of completion.

        Closing the iterator stops what is under way. Raises InputError for what no sample can mend, also when there are no samples.
        """


# Of two packings one cannot say what a third would be.
LEAST_PACKINGS = 3


@dataclass(frozen=True, eq=False)
class Experiment:
    """A test by its name, the model that runs it and the reference that was measured."""

    name: str
    model: Model
    reference: Reference

    @property
    def scatters(self) -> bool:
        """Whether the model's runs are spread over enough packings to say by what these differ. The laboratory's sample is then taken to be one more of them."""
        return len(getattr(self.model, "packings", ())) >= LEAST_PACKINGS

    def evaluate(self, samples: Samples, workers: int | None = None, hopeless: Hopeless | None = None) -> Iterator[tuple[int, Response | Failure]]:
        """Evaluate each sample and yield (row, outcome) in order of completion; a Response is on the reference's control, its observables finite.

        hopeless(id, states): whether a sample need not be run to its end, by the observables of its first states (t, J); asked where the model can be watched.
        """
        outcomes = iter(self.model.evaluate(samples, at=self.reference.control, workers=workers, **self._watch(hopeless)))
        try:
            for row, outcome in outcomes:
                yield row, self._compared(outcome) if isinstance(outcome, Response) else outcome
        finally:
            # Not left to the garbage collector: simulations under way are stopped now.
            if hasattr(outcomes, "close"):
                outcomes.close()

    def one_by_one(self, hopeless: Hopeless | None = None) -> OneByOne:
        """As `evaluate`, but of single samples and from any thread."""
        at, offered, watch = self.reference.control, getattr(self.model, "one_by_one", None), self._watch(hopeless)
        each = offered(at, **watch) if offered else OneByOne(lambda sample: dict(self.model.evaluate(sample, at=at, workers=1, **watch))[0])

        def compared(sample: Samples) -> Response | Failure:
            outcome = each.evaluate(sample)
            return self._compared(outcome) if isinstance(outcome, Response) else outcome

        return replace(each, evaluate=compared)

    def expected_lengths(self, samples: Samples) -> NDArray[np.float64]:
        """How the run lengths of samples compare with one another, (N,): the same for all where the model does not know."""
        expected = getattr(self.model, "expected_lengths", None)
        return np.ones(len(samples)) if expected is None else expected(samples)

    def _watch(self, hopeless: Hopeless | None) -> dict[str, Callable[[int, Response], bool]]:
        if hopeless is None or not getattr(self.model, "can_be_watched", False):
            return {}
        return {"watch": lambda id, response: hopeless(id, self._so_far(response).observables(self.reference.names))}

    def _so_far(self, response: Response) -> Response:
        """The first states of a response, which must be those of the reference. Raises InputError where they are not."""
        first = self.reference.control[: len(response.control)]
        if not (len(first) == len(response.control) and np.allclose(response.control, first)):
            raise InputError(f'experiment "{self.name}": a model that is watched must give the states of the reference, one after the other, and they are others.')
        return response

    def _compared(self, response: Response) -> Response | Failure:
        """The response at the reference's control values, or why it cannot be compared."""
        if missing := [name for name in self.reference.names if name not in response.values]:
            raise InputError(f'experiment "{self.name}": the model returns {", ".join(response.values)}, and the reference needs {", ".join(missing)} too.')
        outcome = self._so_far(response) if response.stopped else interpolate(response, self.reference.control)
        for name in self.reference.names if isinstance(outcome, Response) else ():
            finite = np.isfinite(outcome.values[name])
            if not finite.all():
                where = f"{self.reference.control_name} {self.reference.control[np.argmin(finite)]:g}"
                return Failure("output", f"{name} is not finite at {where}.", outcome.details)
        return outcome
