"""What a model's response would be: its curves reduced to a few numbers, and a Gaussian process on the parameters for each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sklearn.gaussian_process.kernels import Kernel

from graincal.data import Reference
from graincal.inference.likelihood import ReducedLikelihood, columns
from graincal.inference.process import JITTER, Process
from graincal.inference.warping import even_powers, warped

# Components are kept until what is left of the variance is below this part, and at most so many.
LEFT_OUT = 1e-5
MOST_COMPONENTS = 8


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Each evaluation as predicted by an emulator trained on the others.

    error (N,): root mean square of predicted minus found, over that of the curves about their mean. within (N, q): whether each component lies
    in its 90 % interval, nugget included.
    """

    error: NDArray[np.float64]
    within: NDArray[np.bool_]


class Emulator:
    """Predicts responses over the unit cube, (T, J) each, from those of N evaluations.

    Curves are scaled by the reference's peaks and reduced to q principal components. Each component is a Gaussian process (`Process`) over powers of the
    parameters (`even_powers`), with a nugget: what differs between two runs at one Theta. The nugget is in the covariance of the simulator, and not in
    the variance of the mean response. Source: Higdon et al. (2008), JASA 103.

    Where there is an emulator of a cheaper model's responses, what is emulated is the difference from what that one predicts, which varies less. Its
    components follow those of the difference, and its variances are added, although evaluations tell of the sum: the nearer, the more is added
    in excess. Source: Kennedy and O'Hagan (2000), Biometrika 87, with a factor of 1 and one model after the other.

    centre (J T,), basis (J T, q): a response is centre + basis z, observable by observable; q counts the components of both. simulator (J T, J T): the covariance of runs at one
    Theta. truncation (J T,): the variance of what the components leave out. powers: of the parameters that are seen.
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
    ) -> None:
        """unit (N, n), responses (N, T, J), of evaluations that succeeded, at least two. start: an emulator of fewer of them, to begin the search at.

        seen: an index of the parameters that the model sees; the others are not looked at. cheaper: of a cheaper model's responses. begun: points and
        responses of evaluations that were stopped, NaN from some state on.
        """
        peaks = np.abs(reference.values).max(axis=0)
        scale = np.repeat(np.where(peaks > 0, peaks, 1.0), len(reference.control))
        self._cheaper = cheaper
        curves = columns(responses) / scale
        self._total = np.sqrt(np.mean((curves - curves.mean(axis=0)) ** 2))
        if cheaper is not None:
            # Evaluations that follow a first look are near the reference, and differ less than responses do over the box.
            self._total = max(self._total, cheaper._total)
        curves = self._varying(unit, responses, scale)
        middle = curves.mean(axis=0)
        left, sizes, right = np.linalg.svd(curves - middle, full_matrices=False)
        remaining = 1 - np.cumsum(sizes**2) / max(np.sum(sizes**2), 1e-300)
        q = min(MOST_COMPONENTS, int(np.argmax(remaining < LEFT_OUT)) + 1, len(unit) - 1)
        deviation = np.maximum(sizes[:q] / np.sqrt(len(unit)), 1e-12)
        scores = left[:, :q] * sizes[:q] / deviation
        self.centre = scale * middle
        self.basis = scale[:, None] * right[:q].T * deviation
        if cheaper is not None:
            self.centre = self.centre + cheaper.centre
            self.basis = np.column_stack([self.basis, cheaper.basis])
        left_out = np.mean((curves - middle - scores * deviation @ right[:q]) ** 2, axis=0)
        self.truncation = scale**2 * left_out
        self._complete = len(unit)
        noise = np.zeros(scores.shape)
        if begun is not None and len(begun[0]):
            found = _of_first_states(self._varying(*begun, scale) - middle, curves - middle, scores, right[:q].T * deviation, left_out)
            unit, scores, noise = np.concatenate([unit, begun[0]]), np.concatenate([scores, found[0]]), np.concatenate([noise, found[1]])
        unit = unit[:, seen]
        self._seen = seen
        self.powers = np.ones(unit.shape[1]) if start is None else start.powers
        starts = [] if start is None else [process.kernel for process in start._processes]
        self._processes = _processes(warped(unit, self.powers), scores, noise, starts)
        self.powers = even_powers(self._processes, unit, self.powers)
        self._processes = _processes(warped(unit, self.powers), scores, noise, [process.kernel for process in self._processes])
        self.inflation = np.ones(q)
        self.nuggets = np.array([process.nugget for process in self._processes])
        self._size = deviation / np.sqrt(curves.shape[1])

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
        means, variances = zip(*(process.predict(points) for process in self._processes))
        mean, variance = np.column_stack(means), self.inflation * np.column_stack(variances)
        if self._cheaper is None:
            return mean, variance
        below = self._cheaper.predict(unit)
        return np.column_stack([mean, below[0]]), np.column_stack([variance, below[1]])

    def draw(self, unit: NDArray[np.float64], count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Components (count, M, q) that mean responses may have at points (M, n), drawn jointly over the points."""
        points = self._points(unit)
        drawn = [
            process.predict(points)[0] + np.sqrt(inflation) * process.draw(points, count, rng)
            for process, inflation in zip(self._processes, self.inflation)
        ]
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

    def trust(self, weights: NDArray[np.float64]) -> None:
        """Widen the variances of the mean to what the evaluations show, each predicted from the others, where it matters: by weights (N,) that sum to 1, of
        those that were not stopped.

        A process whose lengths fit the whole box is too sure of itself where responses change faster than elsewhere. It is never made surer.
        """
        errors, deviations = self._held_out()
        self.inflation = np.maximum(1.0, weights @ (errors / deviations) ** 2)

    def curves(self, components: NDArray[np.float64], observables: int) -> NDArray[np.float64]:
        """Components (M, q) as curves (M, T, J)."""
        flat = self.centre + components @ self.basis.T
        return np.swapaxes(flat.reshape(*flat.shape[:-1], observables, -1), -1, -2)

    def _held_out(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        errors, deviations = zip(*(process.held_out() for process in self._processes))
        return np.column_stack(errors)[: self._complete], np.column_stack(deviations)[: self._complete]

    def held_out(self) -> HeldOut:
        """How it predicts each evaluation from the others, of those that were not stopped."""
        errors, deviations = self._held_out()
        return HeldOut(np.sqrt(np.sum((errors * self._size) ** 2, axis=1)) / self._total, np.abs(errors) <= 1.6449 * deviations)


def _processes(points: NDArray[np.float64], scores: NDArray[np.float64], noise: NDArray[np.float64], starts: Sequence[Kernel]) -> list[Process]:
    """One for each column of scores (N, q), with their noise (N, q), at points (N, n)."""
    return [Process(points, score, starts[k] if k < len(starts) else None, variance) for k, (score, variance) in enumerate(zip(scores.T, noise.T))]


def _of_first_states(
    begun: NDArray[np.float64], complete: NDArray[np.float64], scores: NDArray[np.float64], basis: NDArray[np.float64], left_out: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What curves (B, J T), NaN from some state on, tell of their scores: values (B, q) and the variance of each.

    Beside one score the others are taken as they are over the complete curves (N, J T), whose scores (N, q) have a mean of 0 and a variance of 1; or as much
    larger as the curve itself is, as far as it goes, for those that were stopped are far off. To the variances is added what the same states of the complete
    curves are wrong by. All that grows once more by as much as the curve is larger: so far off, curves follow the basis less and less (where the complete
    ones are of a seventh of each range, deviations without it are two to four times too small). And where a curve does not follow the basis (J T, q) even so far, the variance of what that leaves out (J T,) is taken
    to be as large as is seen.
    """
    values, variances = np.empty((2, len(begun), basis.shape[1]))
    known = np.isfinite(begun)
    for states in np.unique(known, axis=0):
        rows = np.flatnonzero((known == states).all(axis=1))
        first, floor = basis[states], np.maximum(left_out[states], JITTER)
        wrong = np.mean((_score(complete[:, states], first, floor)[0] - scores) ** 2, axis=0)
        for row in rows:
            curve = begun[row, states]
            white = first / np.sqrt(floor)[:, None]
            missed = curve / np.sqrt(floor) - white @ np.linalg.lstsq(white, curve / np.sqrt(floor), rcond=None)[0]
            excess = max(1.0, np.sum(missed**2) / max(len(curve) - first.shape[1], 1))
            (found,), _, owed = _score(curve[None], first, excess * floor)
            # What the mean of scores of variance 1 squares to on average is what the curve tells of them.
            size = np.sqrt(max(1.0, np.sum((owed * found) ** 2) / np.sum(owed)))
            (found,), variance, _ = _score(curve[None], size * first, excess * floor)
            values[row], variances[row] = size * found, size**4 * (variance + wrong)
    return values, variances


def _score(
    curves: NDArray[np.float64], basis: NDArray[np.float64], left_out: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The most probable scores (N, q) of curves (N, K), the variance of each (q,), the others being of variance 1, and how much a curve tells of it (q,), 0 to 1."""
    weighted = basis / left_out[:, None]
    covariance = np.linalg.inv(np.eye(basis.shape[1]) + basis.T @ weighted)
    # The posterior of a score, with a prior of variance 1, is that of what the curve tells of it: which of the two it owes to what is seen here.
    owed = np.maximum(1 - np.diag(covariance), JITTER)
    return curves @ weighted @ covariance / owed, np.diag(covariance) / owed, owed


def emulated_log_likelihood(likelihoods: Sequence[ReducedLikelihood], emulators: Sequence[Emulator], unit: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of all references, each with its emulator, (M,) at points (M, n)."""
    return sum(likelihood(*emulator.predict(unit)) for likelihood, emulator in zip(likelihoods, emulators))
