"""When a conclusion of the paper holds, does not, and cannot be told; and that its printed numbers were copied rightly."""

import numpy as np
import pytest

from graincal.studies import monte_carlo, particles, range_alpha
from graincal.studies.hartmann2022 import STUDIES
from graincal.studies.judging import (
    CANNOT_BE_TOLD,
    DOES_NOT_HOLD,
    HOLDS,
    Elsewhere,
    Judgement,
    Values,
    all_of,
    at_least,
    at_most,
    correlation_at_least,
    smaller,
)
from graincal.studies.settings import Setup
from graincal.studies.study import Done
from graincal.studies.trend import no_trend


def values(*numbers, floor=0.0, elsewhere=None):
    return Values("ε", numbers, floor, elsewhere=elsewhere)


@pytest.mark.parametrize(
    ("one", "other", "verdict"),
    [
        (values(1.0, 1.1), values(3.0, 3.2), HOLDS),
        (values(3.0, 3.2), values(1.0, 1.1), DOES_NOT_HOLD),
        (values(1.0, floor=1.0), values(1.5, floor=0.2), CANNOT_BE_TOLD),  # runs at the same parameters differ by as much
        (values(1.0, 1.1, floor=np.nan), values(3.0, 3.2), CANNOT_BE_TOLD),  # how far such runs differ is not known
        (values(1.0), values(3.0, 3.2), CANNOT_BE_TOLD),  # how far the seeds of a setting with one spread is not known
        (values(1.0, elsewhere=Elsewhere(0.5, "another")), values(3.0, 3.2), HOLDS),  # but in another setting it is
        (values(1.0, elsewhere=Elsewhere(2.5, "another")), values(3.0, 3.2), CANNOT_BE_TOLD),
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
        (values(1.5, 1.6, floor=1.0), CANNOT_BE_TOLD),  # below it as above it
        (values(0.8, 0.9, floor=1.0), HOLDS),
        (values(3.1, 3.2, floor=1.0), DOES_NOT_HOLD),
        (values(1.5, 1.6, floor=np.nan), CANNOT_BE_TOLD),
        (values(1.0), CANNOT_BE_TOLD),  # one seed
        (values(), CANNOT_BE_TOLD),
    ],
)
def test_a_limit_holds_where_every_seed_is_below_it(one, verdict):
    assert at_most(one, 2.0).verdict == verdict
    # The same rule from the other side.
    assert at_least(one, 2.0).verdict == {HOLDS: DOES_NOT_HOLD, DOES_NOT_HOLD: HOLDS}.get(verdict, verdict)


def test_of_several_comparisons_one_that_does_not_hold_is_enough():
    yes, no, unknown = (Judgement(verdict, f"{verdict}.") for verdict in (HOLDS, DOES_NOT_HOLD, CANNOT_BE_TOLD))
    assert all_of([yes, yes, yes]).verdict == HOLDS
    assert all_of([yes, unknown]).verdict == CANNOT_BE_TOLD
    assert all_of([yes, unknown, no]).verdict == DOES_NOT_HOLD
    assert all_of([]).verdict == CANNOT_BE_TOLD


def test_a_sentence_follows_from_the_numbers():
    assert (
        smaller(values(1.0, 1.2), Values("the other", (3.0, 3.5), 0.0)).reason
        == "ε is 1.10 % (2 seeds: 1.00 to 1.20), and the other is 3.25 % (2 seeds: 3.00 to 3.50)."
    )
    assert "runs at the same parameters differ by 1.0 %" in at_most(values(2.5, floor=1.0), 2.0).reason
    assert "is not known" in at_most(values(2.5, floor=np.nan), 2.0).reason
    one = smaller(values(1.0, elsewhere=Elsewhere(2.5, "mid, α = 10")), values(3.0, 3.2)).reason
    assert "(one seed)" in one and "seeds of mid, α = 10 spread over 2.5 %" in one


def test_a_correlation_is_judged_by_its_interval():
    """Fisher's interval of 0.9 by 11 pairs is 0.65 to 0.97 (z = 1.472 ± 1.96/√8)."""
    assert correlation_at_least("ρ", 0.9, 11, 0.7).verdict == CANNOT_BE_TOLD and "0.65 to 0.97" in correlation_at_least("ρ", 0.9, 11, 0.7).reason
    assert correlation_at_least("ρ", 0.9, 11, 0.6).verdict == HOLDS
    assert correlation_at_least("ρ", 0.9, 11, 0.98).verdict == DOES_NOT_HOLD
    assert correlation_at_least("ρ", np.nan, 11, 0.7).verdict == CANNOT_BE_TOLD


SIZES = (1000, 2000, 5000, 10000)


def test_no_trend_holds_where_its_interval_is_small_and_not_where_there_is_one():
    line = {size: [0.1 * np.log(size / 1000) + off] for size, off in zip(SIZES, (0.001, -0.001, -0.001, 0.001))}
    level = {size: [off] for size, off in zip(SIZES, (0.001, -0.001, -0.001, 0.001))}
    scattered = {size: [off] for size, off in zip(SIZES, (0.2, -0.2, 0.25, -0.15))}
    assert no_trend("x", level, 0.05).verdict == HOLDS
    assert no_trend("x", line, 0.05).verdict == DOES_NOT_HOLD and "changes along the sizes by 0.23" in no_trend("x", line, 0.05).reason
    assert no_trend("x", line, 0.05, falls_only=True).verdict == HOLDS
    assert no_trend("x", scattered, 0.05).verdict == CANNOT_BE_TOLD
    assert no_trend("x", dict(list(line.items())[:3]), 0.05).verdict == CANNOT_BE_TOLD
    assert no_trend("x", level, np.nan).verdict == CANNOT_BE_TOLD


def test_the_printed_errors_are_the_means_of_the_printed_parts():
    """Of ε, Eq. 6, the paper prints both parts: a number that was copied wrongly would not add up."""
    for *_, stress, strain, error in (setting.printed for setting in range_alpha.SETTINGS):
        assert error == pytest.approx((stress + strain) / 2, abs=0.0101)
    for _, _, _, _, _, stress, strain, error, *_ in particles.PRINTED.values():
        assert error == pytest.approx(0.8 * stress + 0.2 * strain, abs=0.0051)
    for _, _, _, _, _, stress, strain, error, *_ in (monte_carlo.GL[0.5e6], monte_carlo.MC[0.5e6]):
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
