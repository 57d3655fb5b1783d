"""Advice on further tests: a soil of two parameters in closed form, and a small packing from the command line."""

import csv
import json
from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import graincal as gc
from graincal.campaign import Listener
from graincal.campaign.run.advice import Advice, AdvisedTest
from graincal.campaign.run.candidate_files import candidate_tests
from graincal.campaign.run.candidate_tests import candidate_test, default_tests
from graincal.dem.preparation import prepare
from graincal.inference.posterior.gain import Gain
from graincal.models import StressPathTest

from . import frictional
from .as_tasks import as_tasks
from .frictional import STRAIN
from .hyperbola import SPACE, model, reference

pytestmark = pytest.mark.usefixtures("fewer_draws")

FIXED = {"log_E": 8, "nu": 0.2, "beta_m": 0.1}
ERRORS = {"stress_ratio": 0.05, "volumetric_strain": 3e-3}
DRAINED, FAILING = "triaxial 1e6 to 0.15", "triaxial 2e6 to 0.15"


def tasks(test, samples, at):
    """The soil; at 2 MPa weak grains have no response."""
    weak = samples.ids[samples.theta[:, 0] < np.median(samples.theta[:, 0])] if test.confining_pressure == 2e6 and len(samples) else []

    def respond(test, sample, at):
        return gc.Failure("diverged", "Weak grains.") if sample.ids[0] in weak else frictional.respond(test, sample, at)

    return as_tasks(respond)(test, samples, at)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign against a test of that soil."""
    folder = tmp_path_factory.mktemp("advice") / "soil"
    rng = np.random.default_rng(1)
    measured = {name: values + ERRORS[name] * rng.standard_normal(len(STRAIN)) for name, values in frictional.curves(32.0, 0.3).items()}
    test, space = gc.TriaxialTest(frictional.packing(), 0.5e6, fixed=FIXED), gc.ParameterSpace({"phi": (10, 50), "eta_m": (0, 1)}, units={"phi": "deg"})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StressPathTest, "tasks", frictional.tasks)
        stop = gc.Stop(max_iterations=3, posterior_shift=0)
        reference = gc.Reference(STRAIN, measured, measurement_errors=ERRORS)
        gc.calibrate(
            test, reference, space, folder=folder, workers=1, stop=stop, seed=1, first_batch=8, packing_scatter=False, discrepancy=False, correlation_length=0.1
        )
    return folder


@pytest.fixture
def closed_form(monkeypatch):
    monkeypatch.setattr(StressPathTest, "tasks", tasks)


def test_the_same_test_once_more_narrows_as_much_as_its_errors_halve(folder, closed_form, tmp_path):
    result = gc.Result.read(folder)
    # As exactly measured as the first, and so it adds as much as that one told. Responses are linear in the parameters and the posterior lies within the ranges, so that it is Gaussian.
    again = gc.CandidateTest("again", result.experiments[0].model, STRAIN, ("stress_ratio", "volumetric_strain"), ERRORS)
    advice = gc.advise(result, [again], folder=tmp_path, workers=1)
    (test,) = advice.tests
    assert test.runs == len(test.draws) == len(advice.theta) and not test.failures
    # Variances halve, which is half of log 2 for each of two parameters. A deviation of two thousand samples is known within 1.6 %, and so is that of the campaign's own.
    np.testing.assert_allclose(test.shares, np.sqrt(0.5), atol=0.03)
    assert test.information == pytest.approx(np.log(2), abs=3 * test.information_error)
    np.testing.assert_allclose(advice.expected_deviations(test), test.shares * result.posterior.std())


def test_failures_are_outcomes_and_too_many_are_no_advice(folder, closed_form, tmp_path):
    advice = gc.advise(gc.Result.read(folder), [DRAINED, FAILING], samples=70, folder=tmp_path, workers=1)
    assert [test.name for test in advice.tests] == ["triaxial, 1 MPa to 15 %"]
    assert list(advice.not_judged) == ["triaxial, 2 MPa to 15 %"]
    assert (
        "only 35 of its 70 runs gave a response" in advice.not_judged["triaxial, 2 MPa to 15 %"]
        and "Weak grains." in advice.not_judged["triaxial, 2 MPa to 15 %"]
    )
    some = gc.advise(gc.Result.read(folder), [DRAINED, FAILING], samples=100, folder=tmp_path, workers=1)
    failed = {test.name: len(test.failures) for test in some.tests}
    assert failed == {"triaxial, 1 MPa to 15 %": 0, "triaxial, 2 MPa to 15 %": 50}
    assert any("50 of its 100 runs gave no response" in each for each in some.remarks)
    # The same soil, and so the same gain: by the truths that both have.
    assert [(one.name, other.name) for one, other in some.alike()] == [tuple(test.name for test in some.tests)]


class Impatient(Listener):
    """Interrupts at an evaluation of a number, and counts those by the test."""

    def __init__(self, at=np.inf):
        self.at, self.counts = at, Counter()

    def evaluated(self, sample, experiment, outcome):
        self.counts[experiment] += 1
        if self.counts.total() == self.at:
            raise KeyboardInterrupt


def test_what_was_broken_off_goes_on(folder, closed_form, tmp_path):
    result, tests = gc.Result.read(folder), [DRAINED, "undrained to 0.15"]
    first, second = Impatient(75), Impatient()
    with pytest.raises(KeyboardInterrupt):
        gc.advise(result, tests, samples=60, folder=tmp_path / "a", workers=1, listeners=[first])
    broken = gc.advise(result, tests, samples=60, folder=tmp_path / "a", workers=1, listeners=[second])
    assert first.counts + second.counts == {"triaxial, 1 MPa to 15 %": 60, "undrained, 500 kPa to 15 %": 60}
    whole = gc.advise(result, tests, samples=60, folder=tmp_path / "b", workers=1)
    assert broken.as_json() == whole.as_json()


def test_an_edited_test_is_no_other_folder(folder, closed_form, tmp_path):
    """Other measurement errors cost no run, and another model is run beside the first one."""
    result = gc.Result.read(folder)
    before = candidate_test(DRAINED, result.experiments[0])
    after = replace(before, measurement_errors={"stress_ratio": 0.1})
    other = replace(before, model=replace(before.model, fixed=FIXED | {"nu": 0.25}))
    runs = []
    for test in (before, after, other):
        counts = Impatient()
        advice = gc.advise(result, [test], samples=60, folder=tmp_path, workers=1, listeners=[counts])
        runs.append(counts.counts.total())
    assert runs == [60, 0, 60] and len(list(tmp_path.iterdir())) == 2
    assert advice.tests[0].runs == 60


def test_too_few_truths_in_common_tell_no_tests_apart():
    def test(name, draws, gain):
        information = gain + 0.01 * np.arange(len(draws))
        made = Gain(information, np.ones((len(draws), 2)), np.ones(2), np.full(len(draws), 100.0), np.ones((len(draws), 2)))
        return AdvisedTest(SimpleNamespace(name=name), 100, (), np.array(draws), made, None)

    much, little, elsewhere = test("much", range(60), 3.0), test("little", range(60), 1.0), test("elsewhere", range(40, 100), 0.1)
    advice = Advice(SPACE, np.ones(2), np.ones((100, 2)), (much, little, elsewhere), {}, ())
    assert np.isnan(advice.difference(much, elsewhere)[0])
    # The first two are apart by two nats, truth by truth with hardly a difference; of the others twenty truths are common.
    little.gain.information[:30] += 0.01
    assert [(one.name, other.name) for one, other in advice.alike()] == [("much", "elsewhere"), ("little", "elsewhere")]


def test_tests_of_a_campaign_are_not_advised_again(folder):
    (experiment,) = gc.Result.read(folder).experiments
    names = [test.name for test in default_tests(experiment)]
    assert names == [
        "triaxial, 200 kPa", "triaxial, 1 MPa", "undrained, 500 kPa", "triaxial extension, 500 kPa", "constant mean stress, 500 kPa", "oedometric, 50 kPa", "isotropic, 50 kPa",
    ]  # fmt: skip
    again = gc.Experiment("again", candidate_test("undrained", experiment).model, experiment.reference)
    assert [test.name for test in default_tests(experiment, [again])] == [name for name in names if name != "undrained, 500 kPa"]


def test_tests_are_said_in_words(folder):
    (experiment,) = gc.Result.read(folder).experiments
    extension = candidate_test("undrained extension 2e5 to 0.1", experiment)
    assert (extension.model.kind, extension.control_name, extension.model.confining_pressure, extension.at[-1]) == ("undrained", "axial_extension", 2e5, 0.1)
    assert extension.model.fixed == FIXED and not extension.measurement_errors
    compression = candidate_test("oedometric 1e4", experiment)
    assert (compression.control_name, compression.at[0], compression.at[-1]) == ("axial_stress", 1e4, 2e5)
    # Of what the campaign states an error of, that one.
    assert set(candidate_test("triaxial", experiment).measurement_errors) == set(ERRORS)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("undraned", 'not "undraned" (did you mean "undrained"?)'),
        ("oedometric extension", "there is no extension of this kind"),
        ("triaxial kPa", 'a confining pressure in Pa was expected as a number above 0, not "kPa"'),
        ("triaxial 1e6 0.1", "KIND [extension] [PRESSURE] [to LAST] was expected"),
        ("triaxial to 20", "fractions between -1 and 1 (not percent), at least one: if 20 % is meant, write 0.2."),
        ("isotropic 1e5 to 1e4", "must be above its confining pressure of 100000 Pa"),
    ],
)
def test_a_mistake_in_a_test_is_one_sentence(call, folder, words, said):
    called = call("advise", folder, "--test", words)
    assert called.code == 1 and called.out == "" and said in called.err and called.err.count("\n") == 1


def test_what_cannot_be_advised_on_is_said(call, folder, tmp_path):
    for arguments, said in {
        ("--samples", "59"): "advice needs at least 60 draws from the posterior, not 59.",
        ("--test", "undrained", "--test", "undrained 5e5"): 'two tests are called "undrained, 500 kPa"',
        ("-o", folder / "campaign.db"): "this file is there already and is not overwritten",
    }.items():
        called = call("advise", folder, *arguments)
        assert called.code == 1 and said in called.err
    gc.calibrate(model(), reference(), SPACE, method="iterative-bayesian", seed=1, workers=1, stop=gc.Stop(max_iterations=1), folder=tmp_path / "paper")
    called = call("advise", tmp_path / "paper")
    assert (called.code, called.err) == (
        1,
        'advice needs to know how sure the parameters are: the campaign\'s method is "iterative-bayesian", and "posterior" was expected.\n',
    )


def test_tests_are_read_from_a_calibration_file(tmp_path):
    frictional.packing().write(tmp_path / "packing.csv")
    (tmp_path / "tests.toml").write_text("""
[parameters]
phi = { range = [10, 50] }
[[experiment]]
name = "oedometer"
control = "axial_stress"
observables = { void_ratio = { measurement_error = 0.001 } }
model = { kind = "oedometric", packing = "packing.csv", confining_pressure = 1e4 }
[[experiment]]
name = "a cycle"
control = "position"
observables = { void_ratio = {} }
model = { kind = "oedometric", packing = "packing.csv", confining_pressure = 1e4, turns = [1e5] }
""")
    with pytest.raises(gc.InputError, match='experiment "a cycle": a reference was expected, whose position says how far the test goes'):
        candidate_tests(tmp_path / "tests.toml")
    text = (tmp_path / "tests.toml").read_text()
    (tmp_path / "tests.toml").write_text(text[: text.rindex("[[experiment]]")])
    (test,) = candidate_tests(tmp_path / "tests.toml")
    assert (test.name, test.control_name, test.observables, test.at[-1]) == ("oedometer", "axial_stress", ("void_ratio",), 2e5)
    assert test.measurement_errors == {"void_ratio": gc.MeasurementError(absolute=0.001)}


def test_a_small_packing_from_the_command_line(call, tmp_path):
    """Two hundred grains, two parameters, short tests: advice is given, drawn and written, and the second time nothing is run."""
    at = np.linspace(0, 0.02, 8)
    test = gc.TriaxialTest(prepare(200, 0.68, seed=1), 2e5, fixed={"nu": 0.2, "beta_m": 0.1, "eta_m": 0.3})
    (curve,) = test.simulate([[8.0, 30.0]], at=at)
    measured = gc.Reference(at, {name: curve.values[name] for name in ("stress_ratio", "volumetric_strain")}, simulated=True)
    space = gc.ParameterSpace({"log_E": (7, 9), "phi": (15, 45)}, units={"phi": "deg"})
    gc.calibrate(test, measured, space, stop=gc.Stop(max_evaluations=24), folder=tmp_path / "campaign", packing_scatter=False, first_batch=12)
    command = ["advise", tmp_path / "campaign", "--test", "triaxial 1e5 to 0.01", "--test", "isotropic 2e4 to 1e5", "--samples", "60"]
    called = call(*command, "-o", tmp_path / "advice.csv", "--plot", tmp_path / "advice.png")
    assert called.code == 0, called.err
    assert "triaxial, 100 kPa to 1 %" in called.out and "isotropic, 20 kPa to 100 kPa" in called.out and "φ [deg]" in called.out
    assert (tmp_path / "advice.png").stat().st_size > 0
    with (tmp_path / "advice.csv").open() as file:
        now, *rows = csv.DictReader(file)
    assert now["test"] == "now" and float(now["sd of phi [deg]"]) > 0
    # Sorted by the gain, and each is more than nothing but for its standard error.
    gains = [float(row["gain [nats]"]) for row in rows]
    assert gains == sorted(gains, reverse=True) and all(gain > -2 * float(row["standard error [nats]"]) for gain, row in zip(gains, rows))
    told = call(*command, "--json")
    assert told.code == 0 and "evaluated" not in told.err
    found = json.loads(told.out)
    assert [each["name"] for each in found["tests"]] == [row["test"] for row in rows] and found["draws"] == 60
    for each, row in zip(found["tests"], rows):
        assert each["information_gain"] == pytest.approx(float(row["gain [nats]"]), rel=1e-5)
