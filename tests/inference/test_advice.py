import numpy as np
import pytest

from graincal.data import ParameterSpace, Samples
from graincal.inference import Iteration, Stop, grade, sample_size_advice


def iteration(error, s, states=50):
    weights = np.full((states, 4), 0.1)
    weights[:, 2] = 0.7
    errors = np.array([30.0, 30.0, error, 30.0])
    samples = Samples(np.arange(4), np.zeros((4, 1)), ("a",))
    return Iteration(0, samples, None, np.zeros(4, dtype=bool), errors[:, None], errors, weights, s, 0.3, 20.0)


@pytest.mark.parametrize(
    ("error", "word", "why"),
    [(1.65, "optimal", "below 2 %"), (4.23, "sub-optimal", "between 2 and 5 %"), (5.22, "sub-optimal", "above 5 %"), (29.97, "no fit", "above 20 %")],
)
def test_the_grade_is_that_of_fig_17(error, word, why):
    result = grade(iteration(error, s=0.01))
    assert result.word == word
    assert len(result.reasons) == 1 and why in result.reasons[0] and f"{error} %" in result.reasons[0]


def test_an_s_well_above_its_threshold_is_named():
    assert len(grade(iteration(1.0, s=0.039)).reasons) == 1
    assert "well above its threshold of 0.01" in grade(iteration(1.0, s=0.05)).reasons[1]
    assert "well above its threshold of 0.002" in grade(iteration(1.0, s=0.01), Stop(s=0.002)).reasons[1]
    assert "well above its threshold of 0.01" in grade(iteration(1.0, s=0.05), Stop(s=False)).reasons[1]


def test_an_iteration_in_which_everything_failed_has_no_result():
    errors = np.full(4, np.nan)
    empty = Iteration(
        0, Samples(np.arange(4), np.zeros((4, 1)), ("a",)), None, np.ones(4, dtype=bool), errors[:, None], errors, np.zeros((50, 4)),
        np.nan, np.nan, np.nan, "only 0 of 4 samples have a usable response",
    )  # fmt: skip
    assert grade(empty).word == "no result"
    assert "only 0 of 4" in grade(empty).reasons[0]


@pytest.mark.parametrize(("width", "alpha"), [(3, 10), (4, 10), (4.5, 20), (6, 20), (8, 30), (9, 40)])
def test_alpha_grows_by_ten_for_each_two_decades_above_four(width, alpha):
    space = ParameterSpace({"log_E": (5, 5 + width), "phi": (0, 60)})
    assert sample_size_advice(space, alpha) is None
    assert f"alpha = {alpha} is advised" in sample_size_advice(space, alpha - 1)


def test_a_space_without_logarithms_needs_no_advice():
    assert sample_size_advice(ParameterSpace({"phi": (0, 60)}), 10) is None
    assert "stiffness" in sample_size_advice(ParameterSpace({"stiffness": (3, 9)}, units={"stiffness": "log10 Pa"}), 10)
