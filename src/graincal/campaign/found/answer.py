"""A sample of a campaign, and its answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.found.repeated import Repeated


@dataclass(frozen=True, eq=False)
class Candidate:
    """One of the samples: its id and iteration, theta (n,) and its error (Hartmann, Cheng, Thornton 2022, Eq. 6), in percent."""

    sample: int
    iteration: int
    theta: NDArray[np.float64]
    error: float

    def __repr__(self) -> str:
        return f"Candidate(sample {self.sample} of iteration {self.iteration}: theta {_listed(self.theta)}, error {self.error:.2f} %)"


@dataclass(frozen=True, eq=False)
class Answer(Repeated):
    """Where the log likelihood expected is the largest (`Emulation.answer`), theta (n,), and the runs there that ended the campaign: ids (R,) and errors (R,), percent, Eq. 6, NaN for a failure."""

    theta: NDArray[np.float64]
    samples: NDArray[np.int64]
    errors: NDArray[np.float64]

    def __repr__(self) -> str:
        known = self.errors[np.isfinite(self.errors)]
        error = f", error {known.mean():.2f} % by {len(known)} runs" if known.size else ", not run yet"
        return f"Answer(theta {_listed(self.theta)}{error})"


def _listed(theta: NDArray[np.float64]) -> str:
    return ", ".join(f"{value:.4g}" for value in theta)
