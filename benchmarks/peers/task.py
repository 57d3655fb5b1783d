"""What a method is given, and how it speaks with a benchmark that runs in another process.

    python task.py PEER < lines > lines

The first line says the task and the seed. From then on each line of the method's asks for an evaluation, which is answered, or says its posterior.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from dataclasses import dataclass
from typing import Any, TextIO

import numpy as np


@dataclass
class Task:
    """Parameters (n,) between low and high, to be found so that curves (T, J) are like `observed`.

    deviations (J,): the standard deviations of independent errors that `observed` has; None where it has none."""

    names: list[str]
    low: np.ndarray
    high: np.ndarray
    observables: list[str]
    control: np.ndarray
    observed: np.ndarray
    deviations: np.ndarray | None
    answers: TextIO
    questions: TextIO

    def evaluate(self, theta: np.ndarray) -> np.ndarray:
        """Curves (N, T, J) at theta (N, n), counted one by one. The process ends here when the benchmark has seen enough."""
        self._say({"evaluate": np.atleast_2d(theta).tolist()})
        answer = self.answers.readline()
        if not answer:
            sys.exit()
        return np.array(json.loads(answer))

    def error(self, curves: np.ndarray) -> np.ndarray:
        """The paper's Eq. 5 and 6 with equal shares, in percent: (N,)."""
        return 100 * np.mean(np.abs(curves - self.observed).sum(axis=1) / np.abs(self.observed).sum(axis=0), axis=1)

    def posterior(self, mean: np.ndarray, std: np.ndarray) -> None:
        """What the evaluations so far say of the parameters, (n,) each."""
        self._say({"posterior": [np.asarray(mean).tolist(), np.asarray(std).tolist()]})

    def _say(self, message: dict[str, Any]) -> None:
        self.questions.write(json.dumps(message) + "\n")
        self.questions.flush()


def main() -> None:
    # Whatever a method prints must not come between the lines.
    questions = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    try:
        calibrate = importlib.import_module(sys.argv[1]).calibrate
    except ModuleNotFoundError as missing:
        questions.write(json.dumps({"missing": missing.name}) + "\n")
        return
    first = json.loads(sys.stdin.readline())
    seed = first.pop("seed")
    arrays = {key: None if first[key] is None else np.array(first[key]) for key in ("low", "high", "control", "observed", "deviations")}
    calibrate(Task(**(first | arrays), answers=sys.stdin, questions=questions), seed, **dict(option.split("=") for option in sys.argv[2:]))


if __name__ == "__main__":
    main()
