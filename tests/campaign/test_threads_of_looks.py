"""How many threads a look at the posterior may use: no more than the calibration has workers."""

import numpy as np
import pytest

import graincal as gc
from graincal.inference import PosteriorFilter
from graincal.inference.emulator import side_by_side


@pytest.mark.parametrize("workers", [1, 3])
def test_they_are_as_many_as_workers(monkeypatch, workers):
    seen = set()
    tell = PosteriorFilter.tell

    def telling(self, *arguments):
        seen.add(side_by_side._allowed.get())
        return tell(self, *arguments)

    monkeypatch.setattr(PosteriorFilter, "tell", telling)
    control = np.linspace(0, 1, 5)
    space, reference = gc.ParameterSpace({"a": (0, 1)}), gc.Reference(control, {"y": 0.4 * control})
    gc.calibrate(gc.PythonModel(lambda theta: {"y": theta[0] * control}), reference, space, workers=workers, max_evaluations=8)
    assert seen == {workers}
    # And what comes after has all again.
    assert side_by_side._allowed.get() == side_by_side.MOST_THREADS
