"""A campaign that begins with what a cheaper one found: it is kept, said, and the same when it goes on."""

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.asked.description import describe
from graincal.campaign.file.config import read_calibration
from graincal.campaign.stored.store import Store
from graincal.report import summarise

from .as_tasks import broken_off
from .hyperbola import SPACE, STRAIN, respond, write_calibration
from .test_campaign import assert_same

pytestmark = pytest.mark.usefixtures("fewer_draws")

LIMITS = {"stress_ratio": 0.05, "volumetric_strain": 2e-4}
TRUTH = np.array([0.6, 0.4])
FEW = {"method": "posterior", "seed": 4, "workers": 1}
POSTERIOR = ('[filter]\nmethod = "iterative-bayesian"\nalpha = 10\n\n[stop]\nmax_iterations = 3\ns = false\ngl_error_increment = false\nerror = false\nerror_increment = false',
             '[filter]\nmethod = "posterior"\nfirst_look = "look"\n\n[stop]\nmax_iterations = 2')  # fmt: skip


def cheap(theta):
    """Weaker by a tenth, and it fails where the other does."""
    found = respond(theta)
    return found | {"stress_ratio": 0.9 * found["stress_ratio"]}


def experiment(function=respond, name="drained"):
    curves = respond(TRUTH)
    return gc.Experiment(name, gc.PythonModel(function), gc.Reference(STRAIN, {name: curves[name] for name in LIMITS}, measurement_errors=LIMITS))


def calibrate(function=respond, iterations=2, **options):
    return gc.calibrate([experiment(function)], space=SPACE, stop=gc.Stop(max_iterations=iterations), **FEW | options)


@pytest.fixture(scope="module")
def look():
    return calibrate(cheap)


def test_the_answer_is_that_of_the_dear_model_alone(look):
    result = calibrate(first_look=look)
    np.testing.assert_allclose(result.answer.theta, TRUTH, atol=0.02)
    assert np.all(np.abs(result.posterior.mean() - TRUTH) < 3 * result.posterior.std())
    assert len(result.calibration.first_look.theta) == look.evaluations - look.failures
    # The first batch is where the cheap model fits.
    spread = [np.abs(each.samples[each.iteration == 0] - TRUTH).mean() for each in (look, result)]
    assert spread[1] < spread[0]
    assert f"and a first look of {look.evaluations - look.failures} evaluations by cheaper models" in summarise(result)


def test_it_goes_on_from_its_folder_alone(look, tmp_path):
    whole = calibrate(first_look=look)
    with broken_off(after=9):
        calibrate(respond, folder=tmp_path / "campaign", first_look=look)
    assert_same(gc.resume(tmp_path / "campaign", gc.PythonModel(respond)), whole)
    store = Store.open(tmp_path / "campaign")
    assert describe(store.calibration) | {"experiments": 0} == store.description | {"experiments": 0}


def test_a_calibration_file_names_its_folder(look, tmp_path):
    path = write_calibration(tmp_path, POSTERIOR)
    with pytest.raises(gc.InputError, match="look: there is no campaign in this folder"):
        read_calibration(path)
    calibrate(cheap, folder=tmp_path / "look")
    np.testing.assert_array_equal(read_calibration(path).first_look.theta, look.samples[~look.failed])
    path.write_text(path.read_text().replace('"posterior"', '"iterative-bayesian"'))
    with pytest.raises(gc.InputError, match='filter.first_look is an option of method = "posterior"'):
        read_calibration(path)


def test_it_is_of_the_same_parameters_and_experiments(look):
    for experiments, space, said in (
        ([experiment(name="another")], SPACE, 'first_look: a first look at the experiment "another" was expected, and this campaign has drained.'),
        ([experiment()], gc.ParameterSpace({"strength": (0, 1), "a": (0, 1)}), "first_look: a first look at strength, a was expected, and this campaign is of"),
        ([experiment()], gc.ParameterSpace({"strength": (5, 6), "dilatancy": (0, 1)}), "first_look: a first look needs at least two evaluations within"),
        ([gc.Experiment("drained", gc.PythonModel(respond), gc.Reference(STRAIN[1:], {"stress_ratio": respond(TRUTH)["stress_ratio"][1:]}))], SPACE,
         "has the observables stress_ratio, volumetric_strain, and stress_ratio were expected"),
    ):  # fmt: skip
        with pytest.raises(gc.InputError, match=said):
            gc.calibrate(experiments, space=space, first_look=look, **FEW)
