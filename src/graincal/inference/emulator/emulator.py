"""What a model's response would be: its curves reduced to a few numbers, and a Gaussian process on the parameters for each of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from graincal.data import Reference
from graincal.inference.emulator.process import Kernel, Process
from graincal.inference.emulator.side_by_side import side_by_side
from graincal.inference.emulator.warping import even_powers, warped
from graincal.inference.likelihood.early_stop import segments
from graincal.inference.likelihood.likelihood import ReducedLikelihood
from graincal.inference.likelihood.reduction import Reduction, columns

Item = TypeVar("Item")


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Each evaluation as predicted from the others, by kernels and components of all.

    error (N,): root mean square of predicted minus found, over that of the curves about their mean. of_mean (N,): the same, were each predicted by the mean of
    all. spread: the root mean square of the curves about their mean, in parts of the reference's peaks. within (N, q): whether each component lies in its 90 % interval, nugget included.
    """

    error: NDArray[np.float64]
    of_mean: NDArray[np.float64]
    spread: float
    within: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Kernels:
    """What the search for an emulator finds, by which it can be made again of the same evaluations: powers (n,) of the parameters that are seen, and a kernel for each component."""

    powers: NDArray[np.float64]
    kernels: tuple[Kernel, ...]


class Emulator:
    """Predicts responses over the unit cube, (T, J) each, from those of N evaluations.

    Curves are scaled by the reference's peaks and reduced to q principal components (`Reduction`); where some evaluations were stopped, segment by segment, so that
    what they came to is known of them as of any other. Each component is a Gaussian process (`Process`) over powers of the
    parameters (`even_powers`), with a nugget: what differs between two runs at one Theta. The nugget is in the covariance of the simulator, and not in
    the variance of the mean response. Source: Higdon et al. (2008), JASA 103.

    Where there is an emulator of a cheaper model's responses, what is emulated is the difference from what that one predicts, which varies less. Its
    components follow those of the difference, and its variances are added, although evaluations tell of the sum: the nearer, the more is added
    in excess. Source: Kennedy and O'Hagan (2000), Biometrika 87, with a factor of 1 and one model after the other.

    centre (J T,), basis (J T, q): a response is centre + basis z, observable by observable; q counts the components of both. simulator (J T, J T): the covariance of runs at one
    Theta. truncation (J T,): the variance of what the components leave out. judges (N,): weights of the evaluations that its variances were judged by. powers: of the parameters that are seen.
    """

    def __init__(
        self,
        unit: NDArray[np.float64],
        responses: NDArray[np.float64],
        reference: Reference,
        start: Emulator | None = None,
        seen: slice | NDArray[np.intp] = slice(None),
        cheaper: Emulator | None = None,
        begun: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
        known: Kernels | None = None,
    ) -> None:
        """unit (N, n), responses (N, T, J), of evaluations that succeeded, at least two. start: an emulator of fewer of them, to begin the search at.

        seen: an index of the parameters that the model sees; the others are not looked at. cheaper: of a cheaper model's responses. begun: points and
        responses of evaluations that were stopped, NaN from some state on. known: what the search found before, of the same evaluations.
        """
        peaks = np.abs(reference.values).max(axis=0)
        scale = np.repeat(np.where(peaks > 0, peaks, 1.0), len(reference.control))
        self._cheaper = cheaper
        curves = columns(responses) / scale
        # About the mean of all, as a process predicts each from the others that knows nothing of it.
        self._from_mean = np.sqrt(np.mean((curves - curves.mean(axis=0)) ** 2, axis=1))
        self._total = np.sqrt(np.mean(self._from_mean**2))
        if cheaper is not None:
            # Evaluations that follow a first look are near the reference, and differ less than responses do over the box.
            self._total = max(self._total, cheaper._total)
        curves = self._varying(unit, responses, scale)
        middle = curves.mean(axis=0)
        if begun is not None and not len(begun[0]):
            begun = None
        states = len(reference.control)
        reduction = Reduction(curves - middle, np.tile(segments(states) if begun is not None else np.zeros(states, dtype=np.int64), responses.shape[2]))
        self.centre = scale * middle
        self.basis = scale[:, None] * reduction.basis
        if cheaper is not None:
            self.centre = self.centre + cheaper.centre
            self.basis = np.column_stack([self.basis, cheaper.basis])
        # Over all evaluations, which is more than near the reference: counted as there, the posterior of a measured sand is narrower, and was not settled after twice as many runs (docs/posterior.md).
        self.truncation = scale**2 * reduction.left_out
        scores, self._complete = reduction.scores, len(unit)
        if begun is not None:
            unit = np.concatenate([unit, begun[0]])
            scores = np.concatenate([scores, reduction.of_first_segments(self._varying(*begun, scale) - middle)])
        unit = unit[:, seen]
        self._seen = seen
        self._by_segments = begun is not None
        self._processes, self.powers = self._found(unit, scores, start) if known is None else self._made(unit, scores, known)
        self.inflation = np.ones(scores.shape[1])
        self.judges = np.full(self._complete, 1 / self._complete)
        self.nuggets = np.array([process.nugget for process in self._processes])
        self._size = np.linalg.norm(reduction.basis, axis=0) / np.sqrt(curves.shape[1])

    def _found(self, unit: NDArray[np.float64], scores: NDArray[np.float64], start: Emulator | None) -> tuple[list[Process], NDArray[np.float64]]:
        """The most probable processes of scores (N, q) at points (N, n), and the powers."""
        powers = np.ones(unit.shape[1]) if start is None else start.powers
        # Kernels of the same numbers: of whole curves, or of segments.
        starts = [process.kernel for process in start._processes] if start is not None and start._by_segments == self._by_segments else []
        processes = _processes(warped(unit, powers), scores, starts)
        powers = even_powers(processes, unit, powers)
        return _processes(warped(unit, powers), scores, [process.kernel for process in processes]), powers

    def _made(self, unit: NDArray[np.float64], scores: NDArray[np.float64], known: Kernels) -> tuple[list[Process], NDArray[np.float64]]:
        """The processes by kernels that are known."""
        points = warped(unit, known.powers)
        return _side_by_side(list(zip(scores.T, known.kernels)), lambda each: Process(points, each[0], known=each[1]), len(points)), known.powers

    @property
    def kernels(self) -> Kernels:
        """By which it can be made again of the same evaluations."""
        return Kernels(self.powers, tuple(process.kernel for process in self._processes))

    @property
    def simulator(self) -> NDArray[np.float64]:
        """The covariance of a run about the mean response at its Theta, (J T, J T)."""
        own = self.basis[:, : len(self.nuggets)]
        return (own * self.nuggets) @ own.T

    def added(self, scatters: bool) -> NDArray[np.float64]:
        """What a covariance of the reference about the emulated response holds beside the errors, (J T, J T): what the components leave out, and the scatter
        of runs where the reference scatters like them."""
        return np.diag(self.truncation) + (self.simulator if scatters else 0)

    def predict(self, unit: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The mean (M, q) of the components of the mean response at points (M, n), and the variance of that mean (M, q), without the nugget."""
        points = self._points(unit)
        means, variances = zip(*side_by_side(lambda process: process.predict(points), self._processes, self._numbers(points)))
        mean, variance = np.column_stack(means), self.inflation * np.column_stack(variances)
        if self._cheaper is None:
            return mean, variance
        below = self._cheaper.predict(unit)
        return np.column_stack([mean, below[0]]), np.column_stack([variance, below[1]])

    def draw(self, unit: NDArray[np.float64], count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Components (count, M, q) that mean responses may have at points (M, n), drawn jointly over the points."""
        points = self._points(unit)
        # Drawn in turn, whichever component is the first to be computed.
        normal = [rng.standard_normal((count, len(points))) for _ in self._processes]

        def of_component(number: int) -> NDArray[np.float64]:
            process = self._processes[number]
            return process.predict(points)[0] + np.sqrt(self.inflation[number]) * process.drawn(points, normal[number])

        drawn = side_by_side(of_component, range(len(normal)), self._numbers(points))
        if self._cheaper is None:
            return np.stack(drawn, axis=2)
        return np.concatenate([np.stack(drawn, axis=2), self._cheaper.draw(unit, count, rng)], axis=2)

    def _varying(self, unit: NDArray[np.float64], responses: NDArray[np.float64], scale: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the processes are of, as scaled curves (N, J T): responses (N, T, J), or what they differ by from a cheaper model's."""
        curves = columns(responses) / scale
        if self._cheaper is None:
            return curves
        return curves - columns(self._cheaper.curves(self._cheaper.predict(unit)[0], responses.shape[2])) / scale

    def _points(self, unit: NDArray[np.float64]) -> NDArray[np.float64]:
        """The processes' coordinates of points (M, n)."""
        return warped(unit[:, self._seen], self.powers)

    def _numbers(self, points: NDArray[np.float64]) -> int:
        """How many covariances a component has with points (M, n)."""
        return len(points) * len(self._processes[0].values)

    def trust(self, weights: NDArray[np.float64]) -> None:
        """Widen the variances of the mean to what the evaluations show, each predicted from the others, where it matters: by weights (N,) that sum to 1, of
        those that were not stopped.

        A process whose lengths fit the whole box is too sure of itself where responses change faster than elsewhere. It is never made surer.
        """
        errors, deviations = self._held_out()
        self.inflation = np.maximum(1.0, weights @ (errors / deviations) ** 2)
        self.judges = weights

    @property
    def coverage(self) -> float:
        """How much of the components of the evaluations that its variances were judged by lies in the 90 % intervals, each predicted from the others. What
        was widened for these is in them: it tells of what is left."""
        return float(self.judges @ self.held_out().within.mean(axis=1))

    def curves(self, components: NDArray[np.float64], observables: int) -> NDArray[np.float64]:
        """Components (M, q) as curves (M, T, J)."""
        flat = self.centre + components @ self.basis.T
        return np.swapaxes(flat.reshape(*flat.shape[:-1], observables, -1), -1, -2)

    def _held_out(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Of those that were not stopped, which come first: errors and standard deviations (N, q)."""
        errors, deviations = zip(*(process.held_out() for process in self._processes))
        of_errors, of_deviations = (np.column_stack([each[: self._complete] for each in every]) for every in (errors, deviations))
        return of_errors, of_deviations

    def held_out(self) -> HeldOut:
        """How it predicts each evaluation from the others, of those that were not stopped."""
        errors, deviations = self._held_out()
        # What was widened is the variance of the mean; another run scatters about that as before.
        deviations = np.sqrt(self.inflation * (deviations**2 - self.nuggets) + self.nuggets)
        error = np.sqrt(np.sum((errors * self._size) ** 2, axis=1))
        return HeldOut(error / self._total, self._from_mean / self._total, float(self._total), np.abs(errors) <= 1.6449 * deviations)


def _processes(points: NDArray[np.float64], scores: NDArray[np.float64], starts: Sequence[Kernel]) -> list[Process]:
    """One for each column of scores (N, q) at points (N, n)."""
    return _side_by_side(range(scores.shape[1]), lambda k: Process(points, scores[:, k], starts[k] if k < len(starts) else None), len(points))


def _side_by_side(items: Sequence[Item], process: Callable[[Item], Process], count: int) -> list[Process]:
    """A process of so many points for each item. Threads of linear algebra are limited for all at once: each that limited them by itself would lift the limit for the others at its end."""
    with threadpool_limits(1):
        return side_by_side(process, items, count**2)


def emulated_log_likelihood(likelihoods: Sequence[ReducedLikelihood], emulators: Sequence[Emulator], unit: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of all references, each with its emulator, (M,) at points (M, n)."""
    logs = np.zeros(len(unit))
    for likelihood, emulator in zip(likelihoods, emulators):
        logs += likelihood(*emulator.predict(unit))
    return logs
