"""Scatter of the runs is told from what an emulator does not resolve: by runs at one place."""

import numpy as np
import pytest

import graincal as gc

STRAIN = np.linspace(0, 0.2, 11)
SPACE = gc.ParameterSpace({"a": (0, 1), "b": (0, 1)})
OPTIONS = {"seed": 1, "workers": 1, "max_evaluations": 40}


def smooth(a, b):
    return 1 + (1 + a) * (1 - np.exp(-STRAIN / 0.03 * (0.5 + b)))


def wiggly(theta):
    """No run of it differs from another at the same place, and no emulator resolves its waves by a few runs."""
    a, b = theta
    return {"stress_ratio": smooth(a, b) + 0.3 * np.sin(40 * a + 52 * b) * STRAIN / 0.2}


def scattering(theta):
    """Two runs a millionth apart differ, by 5 % of the peak."""
    a, b = theta
    noise = np.random.default_rng(int(1e9 * a + 1e7 * b)).standard_normal()
    return {"stress_ratio": smooth(a, b) + 0.13 * noise * STRAIN / 0.2}


@pytest.mark.parametrize(("respond", "scatters"), [(wiggly, False), (scattering, True)])
def test_scatter_is_said_of_runs_that_scatter_alone(respond, scatters):
    reference = gc.Reference(STRAIN, {"stress_ratio": smooth(0.4, 0.6)}, measurement_errors={"stress_ratio": 0.02})
    result = gc.calibrate(gc.PythonModel(respond), reference, SPACE, **OPTIONS)
    codes = [each.code for each in result.remarks]
    assert result.scatter.is_most is scatters
    assert ("runs-scatter" in codes) is scatters and (scatters or {"emulator-rough", "emulator-predicts-nothing"} & set(codes))
    assert ("answer-runs-alike" in codes) is not scatters
