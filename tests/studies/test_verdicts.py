"""When a conclusion of the paper holds, does not, and cannot be told; and that its printed numbers were copied rightly."""

import numpy as np
import pytest

from graincal.studies import monte_carlo, particles, range_alpha
from graincal.studies.hartmann2022 import STUDIES
from graincal.studies.records import CANNOT_BE_TOLD, DOES_NOT_HOLD, HOLDS, Judgement, Values, all_of, at_most, smaller
from graincal.studies.settings import Setup
from graincal.studies.study import Done


def values(*numbers, floor=0.0):
    return Values("ε", numbers, floor)


@pytest.mark.parametrize(
    ("one", "other", "verdict"),
    [
        (values(1.0, 1.1), values(3.0, 3.2), HOLDS),
        (values(3.0, 3.2), values(1.0, 1.1), DOES_NOT_HOLD),
        (values(1.0, floor=1.0), values(1.5, floor=0.2), CANNOT_BE_TOLD),  # runs at the same parameters differ by as much
        (values(1.0, 3.0), values(2.5, 3.5), CANNOT_BE_TOLD),  # seeds spread as far
        (values(), values(1.0), CANNOT_BE_TOLD),  # was not run
    ],
)
def test_a_difference_must_be_above_the_floor_and_the_spread_of_seeds(one, other, verdict):
    assert smaller(one, other).verdict == verdict


@pytest.mark.parametrize(
    ("one", "verdict"),
    [
        (values(1.0, 1.9), HOLDS),
        (values(2.5, 3.0), DOES_NOT_HOLD),
        (values(1.5, 2.5), CANNOT_BE_TOLD),
        (values(2.5, floor=1.0), CANNOT_BE_TOLD),
        (values(), CANNOT_BE_TOLD),
    ],
)
def test_a_limit_holds_where_every_seed_is_below_it(one, verdict):
    assert at_most(one, 2.0).verdict == verdict


def test_of_several_comparisons_one_that_does_not_hold_is_enough():
    yes, no, unknown = (Judgement(verdict, f"{verdict}.") for verdict in (HOLDS, DOES_NOT_HOLD, CANNOT_BE_TOLD))
    assert all_of([yes, yes, yes]).verdict == HOLDS
    assert all_of([yes, unknown]).verdict == CANNOT_BE_TOLD
    assert all_of([yes, unknown, no]).verdict == DOES_NOT_HOLD
    assert all_of([]).verdict == CANNOT_BE_TOLD


def test_a_sentence_follows_from_the_numbers():
    assert smaller(values(1.0), Values("the other", (3.0,))).reason == "ε is 1 %, and the other is 3 %."
    assert "runs at the same parameters differ by 1 %" in at_most(values(2.5, floor=1.0), 2.0).reason


def test_the_printed_errors_are_the_means_of_the_printed_parts():
    """Of ε, Eq. 6, the paper prints both parts: a number that was copied wrongly would not add up."""
    for *_, stress, strain, error in (setting.printed for setting in range_alpha.SETTINGS):
        assert error == pytest.approx((stress + strain) / 2, abs=0.0101)
    for *_, stress, strain, error in particles.PRINTED.values():
        assert error == pytest.approx(0.8 * stress + 0.2 * strain, abs=0.0051)
    for *_, stress, strain, error in (monte_carlo.GL[0.5e6], monte_carlo.MC[0.5e6]):
        assert error == pytest.approx((stress + strain) / 2, abs=0.0101)


def test_every_study_says_what_the_paper_found_with_nothing_run(tmp_path):
    """Without data and without runs there are the paper's numbers alone, and no conclusion."""
    setup, done = Setup(tmp_path), Done(tmp_path / "work")
    numbered = set()
    for name, study in STUDIES.items():
        findings = study.findings(setup, done)
        assert name == study.name and findings.conclusions and {each.judgement.verdict for each in findings.conclusions} == {CANNOT_BE_TOLD}
        numbered |= {table.number for table in findings.tables if isinstance(table.number, int)}
        printed = [row for table in findings.tables for row in table.rows if row.paper is not None]
        assert printed and all(np.isfinite(row.paper) for row in printed)
    assert numbered == set(range(3, 13))
