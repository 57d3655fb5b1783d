"""What is said of a posterior: whatever its state, nothing that contradicts itself, and by the report, the status and Python in the same words."""

import json
import re
import subprocess
import sys
from copy import copy
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.found.by_emulators import ByEmulators
from graincal.campaign.found.remark import BY_EMULATORS, CODES, EXCLUSIVE, IDENTIFIED, LEVELS
from graincal.campaign.found.remarks import WORDS, remarks
from graincal.campaign.found.scatter import Scatter
from graincal.campaign.found.status import status
from graincal.campaign.found.trust import LEAST_COVERAGE, MUCH_UNSURE
from graincal.inference.posterior.likely_runs import LikelyRuns
from graincal.models import StressPathTest
from graincal.report import summarise
from graincal.report.verdict import under_headings

from . import frictional

pytestmark = pytest.mark.usefixtures("fewer_draws")

SPACE = gc.ParameterSpace({"phi": (10, 50), "eta_m": (0, 1), "beta_m": (0, 1)}, units={"phi": "deg"})
FIXED = {"log_E": 8, "nu": 0.2}
PACKING = frictional.packing()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("remarks") / "campaign"
    reference = gc.Reference(frictional.STRAIN, frictional.curves(32.0, 0.3), measurement_errors={"stress_ratio": 0.01})
    options = {
        "seed": 1,
        "workers": 1,
        "first_batch": 12,
        "stop": gc.Stop(max_iterations=2),
        "packing_scatter": False,
        "truth": {"phi": 32.0},
        "folder": folder,
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StressPathTest, "tasks", frictional.tasks)
        gc.calibrate(gc.TriaxialTest(PACKING, 0.5e6, fixed=FIXED), reference, SPACE, **options)
    return folder


@pytest.fixture(scope="module")
def result(folder):
    return gc.Result.read(folder)


def spread(found, widths, correlation=0.0):
    """What was found, with samples about the middle of the ranges that have these standard deviations over the prior's, the first two correlated."""
    rng, count = np.random.default_rng(1), len(found.explored.theta)
    normal = rng.standard_normal((count, 3))
    normal[:, 1] = correlation * normal[:, 0] + np.sqrt(1 - correlation**2) * normal[:, 1]
    unit = 0.5 + np.array(widths) / np.sqrt(12) * normal
    other = replace(found, explored=replace(found.explored, theta=SPACE.from_unit(unit), log_weights=np.zeros(count)))
    other.__dict__.pop("posterior", None)
    return other


def altered(result, learnt=None, **changes):
    """The result with other attributes, and then other figures of what was learnt last."""
    other = copy(result)
    for name in ("remarks", "knowledge", "emulation", "scatter"):
        other.__dict__.pop(name, None)
    # What takes the curves, which no state here changes.
    other.knowledge = result.knowledge
    for name, value in changes.items():
        setattr(other, name, value)
    other.learnt = (*other.learnt[:-1], replace(other.learnt[-1], **learnt or {}))
    return other


ENDINGS = [
    {"stopped_by": "posterior_shift", "stopped_because": "What the emulator does not know moves it little."},
    {"stopped_by": "max_evaluations", "stopped_because": "The limit is reached."},
    {"stopped_by": "proposal", "stopped_because": "Nothing could be drawn."},
    {"stopped_by": None, "stopped_because": None},
]
EMULATORS = [
    {"held_out": (0.02,), "of_mean": (0.5,), "coverage": 0.9},
    {"held_out": (0.3,), "of_mean": (0.5,), "coverage": 0.9, "dropped": 0.3, "lost": 0.3},
    {"held_out": (0.3,), "of_mean": (0.2,), "coverage": 0.9, "pareto_k": 0.9, "weights": np.full(300, 1 / 300)},
    {"held_out": (0.02,), "of_mean": (0.5,), "coverage": 0.6},
    {"held_out": (0.3,), "of_mean": (0.5,), "coverage": 0.6, "lost": 0.7},
]
LEARNT = [
    {"doubt": 0.1, "confirmed": 1.0, "siblings": (6,), "apart": (1.0,)},
    {"doubt": 0.9, "confirmed": np.nan, "siblings": (6,), "apart": (3.0,)},
    {
        "doubt": 0.1,
        "confirmed": np.nan,
        "siblings": (0,),
        "apart": (np.nan,),
        "fits_about_as_well": LikelyRuns(2, (20.0, 0.2, 0.1), (30.0, 0.3, 0.9), -10.0, 3),
    },
    {
        "doubt": 0.1,
        "confirmed": 1.0,
        "siblings": (6,),
        "apart": (1.0,),
        "fits_about_as_well": LikelyRuns(200, (20.0, 0.1, 0.1), (40.0, 0.4, 0.9), -30.0, 3, 12.0),
    },
    {"doubt": 0.1, "confirmed": 0.1, "siblings": (), "apart": (), "fits_about_as_well": None},
]
KNOWN = [None, ByEmulators(0.05, 1.0), ByEmulators(0.3, 9.0), ByEmulators(0.9, 0.01, (0.7, 0.3))]


def states(result):
    """Results in combinations of what may be, each with what is known by emulators."""
    last, stop, rng = result.iterations[-1], result.calibration.stop, np.random.default_rng(1)

    def at(theta, errors=last.errors):
        samples = gc.Samples(last.samples.ids, np.tile(theta, (len(last.samples), 1)), SPACE.names)
        iterations = (*result.iterations[:-1], replace(last, samples=samples, errors=np.array(errors)))
        return {"iterations": iterations, "errors": np.concatenate([iteration.errors for iteration in iterations])}

    middle = SPACE.from_unit(np.full(3, 0.5))
    # Not run again yet; at the end of the ranges; runs that scatter, by much or by little; and one of them failed.
    answers = [
        {},
        {"iterations": result.iterations[:-1]},
        at(SPACE.high),
        at(middle, [1.0, 6.0, 7.0]),
        at(middle, [6.0, 6.1, 6.2]),
        at(middle, [np.nan, 7.0, 7.001]),
    ]
    posteriors = [((0.1, 0.5, 0.9), 0.0), ((0.2, 0.2, 0.2), 0.95)]
    looks = [replace(spread(result.found, *posterior), **emulator) for posterior, emulator in product(posteriors, EMULATORS)]
    for _ in range(800):
        found, ending, learnt, answer, known = (each[rng.integers(len(each))] for each in (looks, ENDINGS, LEARNT, answers, KNOWN))
        yield altered(result, learnt, **ending, **answer, found=found), known
    found = spread(result.found, (0.1, 0.5, 0.9))
    for enough, failed in product((False, 0.25), (np.zeros(len(result.failed), dtype=bool), np.arange(len(result.failed)) % 2 == 0)):
        calibration = replace(result.calibration, stop=replace(stop, posterior_shift=enough))
        for ending, known in product(ENDINGS, KNOWN):
            yield altered(result, **ending, found=found, calibration=calibration, failed=failed), known
    # Of a model whose runs at one place differ.
    rough = replace(found, held_out=(0.3,), of_mean=(0.5,))
    yield altered(result, found=rough, scatter=Scatter(0.05, 0.06), **at(middle, [6.0, 6.1, 6.2])), KNOWN[1]
    # Of two packings; of one that never came to a response; and of one for which too few did.
    test = gc.TriaxialTest([PACKING, PACKING], 0.5e6, fixed=FIXED)
    two = replace(result.calibration, experiments=[replace(result.experiments[0], model=test)])
    yield altered(result, calibration=two, found=found, stopped_by="posterior_shift"), KNOWN[1]
    for failed in (np.ones(len(result.failed), dtype=bool), result.failed):
        yield altered(result, {"fits_about_as_well": None}, found=None, failed=failed, stopped_by="failures"), None
    beside = gc.Reference(
        frictional.STRAIN,
        {"stress_ratio": frictional.curves(32.0, 0.3)["stress_ratio"]},
        recorded={"volumetric_strain": frictional.curves(32.0, 0.3)["volumetric_strain"]},
    )
    recorded = replace(result.calibration, experiments=[replace(result.experiments[0], reference=beside)])
    yield altered(result, found=found, calibration=recorded), KNOWN[1]
    yield altered(result, found=found, accepted=(Doubt("stress-ratio-high", "the stress ratio reaches 40.", "drained"),), code_changed="model.py"), KNOWN[1]


def test_no_state_is_said_anything_of_that_contradicts_itself(result):
    reached = set()
    for state, known in states(result):
        said = remarks(state, known)
        codes = [each.code for each in said]
        reached |= set(codes)
        assert not [pair for pair in EXCLUSIVE if pair <= set(codes)], codes
        json.dumps([each.as_json() for each in said], allow_nan=False)
        assert all(each.level == LEVELS[each.code] and each.text and "{" not in each.plain for each in said)
        texts = " ".join(each.plain for each in said)
        settled = state.settled and state.found is not None and state.found.predicts
        if state.found is not None:
            of_each = [code for code in codes if code in WORDS]
            assert len(of_each) == 3
            assert set(of_each) <= set(IDENTIFIED) if settled else set(of_each) == {"interval-so-far"}
            assert ("not-settled" in codes) is not settled and ("settled" in codes) is settled
        if not settled:
            assert not any(words in texts for words in ("is identified:", "Identified:", "eakly identified", "ot identified"))
        fits = state.fits_about_as_well
        assert ("one run by itself tells little" in texts) is (fits is not None and fits.enough and fits.scattered)
        if "would narrow" in texts:
            assert known.unsure > MUCH_UNSURE and not settled and state.found.coverage >= LEAST_COVERAGE
        assert not ("too narrow" in texts and "Intervals are wider" in texts)
        assert not ("are stated," in texts and "No measurement error is stated" in texts)
        if "Nothing that was looked at speaks against it" in texts:
            assert known and not any(each.level == "doubt" for each in said)
        # What is told without emulators is told in the same words with them; but for what was not stored.
        if known and state.learnt[-1].siblings:
            assert [each for each in said if each.code not in BY_EMULATORS] == list(remarks(state))
        page = " ".join(text for _, texts in under_headings(said) for text in texts)
        assert all(each.text in page for each in said)
    assert reached == set(LEVELS)


def test_codes_have_one_level_and_pairs_are_of_codes():
    assert len(LEVELS) == sum(map(len, CODES.values()))
    assert all(len(pair) == 2 and pair <= set(LEVELS) for pair in EXCLUSIVE)
    assert set(BY_EMULATORS) | set(IDENTIFIED) <= set(LEVELS)


def test_the_documents_list_every_code():
    text = (Path(__file__).parents[2] / "docs" / "remarks.md").read_text()
    rows = {(level, code, star == " *") for level, code, star in re.findall(r"^\| (\w+) \| `([\w-]+)`( \*)? \|", text, re.M)}
    assert rows == {(level, code, code in BY_EMULATORS) for code, level in LEVELS.items()}


def test_python_the_status_and_the_terminal_say_the_same(folder, result, call):
    found = status(folder)
    json.dumps(found, allow_nan=False)
    assert found["remarks"] == [each.as_json() for each in result.remarks if each.code not in BY_EMULATORS]
    said = summarise(result)
    assert all(each.plain in said for each in result.remarks)
    fits, lines = result.fits_about_as_well, call("status", folder).out
    assert found["fits_about_as_well"] == {
        "runs": fits.count,
        "enough": fits.enough,
        "range": {name: [low, high] for name, low, high in zip(SPACE.names, fits.low, fits.high)},
    }
    assert "The posterior has not settled: " in lines and "fit about as well as" in lines and "Preliminary" not in lines
    assert {each.code for each in result.remarks} >= {
        "interval-so-far",
        "identifiability-open",
        "not-settled",
        "preliminary",
        "one-packing",
        "fits-about-as-well",
        "answer",
        "stopped",
    }
    of_each = [each.numbers for each in result.remarks if each.code == "interval-so-far"]
    assert [numbers["parameter"] for numbers in of_each] == list(SPACE.names) and of_each[0]["truth"] == 32.0 and of_each[1]["truth"] is None
    assert {name: {numbers["parameter"]: numbers[name] for numbers in of_each} for name in ("mean", "std", "interval_90")} == found["posterior"]


def test_what_is_given_by_other_methods_is_nothing():
    result = gc.calibrate(gc.PythonModel(lambda theta: {"y": theta[0] * np.arange(1.0, 6)}), gc.Reference(np.arange(5.0), {"y": 0.5 * np.arange(1.0, 6)}), gc.ParameterSpace({"a": (0, 1)}),
                          method="iterative-bayesian", stop=gc.Stop(max_iterations=1), workers=1)  # fmt: skip
    assert result.remarks == () and result.fits_about_as_well is None


def test_campaigns_need_no_report():
    # Whoever asks how far a campaign is waits for no figures.
    code = (
        "import sys, graincal.campaign.found.record, graincal.campaign.found.status; sys.exit(any(name.startswith('graincal.report') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
