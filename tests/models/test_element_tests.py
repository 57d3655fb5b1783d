"""The built-in tests as models: what drives them, what they return, and that a campaign can store them."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest

import graincal as gc
from graincal import InputError, TriaxialTest, demo
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.description import describe, restore
from graincal.campaign.file.models import StressPathModel
from graincal.cli.simulate import Simulation
from graincal.dem.stress_path_table import StressPathTable
from graincal.models import TESTS
from graincal.models.economy import INERTIAL_NUMBER, Economy
from graincal.models.stress_path import unusual

THETA = [7.8, 0.2, 30.0, 0.1, 0.3]
PRESSURE = 1e5
SPACE = gc.ParameterSpace.paper()
TABLE = "stress_x,stress_y,strain_z,record\n1e5,1e5,0.001,\n1e5,1e5,0.002,no\n1e5,1e5,0.003,\n"


@pytest.fixture(scope="module")
def packing():
    return demo.packing()


@pytest.fixture
def table(tmp_path):
    (tmp_path / "path.csv").write_text(TABLE)
    return StressPathTable.read(tmp_path / "path.csv")


def curve(test, at):
    (response,) = test.simulate([THETA], at=at, threads=1)
    assert isinstance(response, gc.Response) and tuple(response.values) == test.returned
    return response.values


def test_extension_can_be_driven_by_a_control_that_increases(packing):
    extended = curve(gc.TriaxialTest(packing, PRESSURE, control="axial_extension"), [0.0, 0.002, 0.004])
    expected = curve(gc.TriaxialTest(packing, PRESSURE), [0.0, -0.002, -0.004])
    for name, values in expected.items():
        assert np.array_equal(extended[name], values), name
    assert np.array_equal(extended["axial_extension"], -extended["axial_strain"])


def test_the_excess_pore_pressure_is_what_the_skeleton_has_lost_of_the_lateral_stress(packing):
    undrained = curve(gc.UndrainedTest(packing, PRESSURE), [0.0, 0.002])
    lateral = undrained["mean_stress"] - undrained["deviatoric_stress"] / 3
    assert np.allclose(undrained["excess_pore_pressure"], PRESSURE - lateral, rtol=0, atol=1e-9 * PRESSURE)
    assert undrained["excess_pore_pressure"][0] == pytest.approx(0, abs=1e-3 * PRESSURE)
    assert np.allclose(undrained["volumetric_strain"], 0, rtol=0, atol=1e-11)


def test_a_sample_that_liquefies_is_recorded_and_flagged(packing):
    # Smooth grains sheared in extension at constant volume lose their contacts: the water takes the whole confining pressure.
    test = gc.UndrainedTest(packing, 5e5, largest_flagged_share=1.0)
    (liquefied,) = test.simulate([[8.7, 0.2, 5.0, 0.0, 0.0]], at=[-0.032], threads=1)
    assert liquefied.details["flagged"] >= 1 and liquefied.values["flagged"][0] == 1
    assert liquefied.values["excess_pore_pressure"][0] == pytest.approx(5e5, rel=1e-3)
    assert liquefied.values["coordination_number"][0] < 1


def test_what_drives_an_oedometric_test_can_be_chosen(packing):
    by_stress = curve(gc.OedometricTest(packing, PRESSURE, control="axial_stress"), [1e5, 2e5])
    assert np.allclose(by_stress["axial_stress"], [1e5, 2e5], rtol=1e-3, atol=0)
    by_strain = curve(gc.OedometricTest(packing, PRESSURE), [by_stress["axial_strain"][1]])
    # The same strain by other rests on the way. The grains take another way there, a few percent of the stress for hundreds of them.
    assert by_strain["axial_stress"][0] == pytest.approx(2e5, rel=0.1)
    assert np.allclose(by_stress["lateral_stress"][0] * by_stress["stress_ratio"][0], by_stress["axial_stress"][0], rtol=1e-12, atol=0)


def test_isotropic_and_sheared_states_are_returned(packing):
    assert np.allclose(curve(gc.IsotropicTest(packing, PRESSURE), [1e5, 2e5, 1e5])["mean_stress"], [1e5, 2e5, 1e5], rtol=1e-3, atol=0)
    sheared = curve(gc.ConstantMeanStressTest(packing, PRESSURE), [0.0, 0.002])
    assert np.allclose(sheared["mean_stress"], PRESSURE, rtol=1e-3, atol=0) and sheared["stress_ratio"][1] > 1.01


def experiment_of(test, control, values):
    reference = gc.Reference(values, {"void_ratio": np.full(len(values), 0.6)}, control_name=control)
    return Calibration(SPACE, [gc.Experiment("one", test, reference)])


@pytest.mark.parametrize("kind", TESTS)
def test_a_test_is_described_and_restored(packing, table, kind):
    # The last of its controls, that which is not there by default.
    test = TESTS[kind](packing, PRESSURE, control=TESTS[kind].controls[-1], **({"table": table} if kind == "table" else {}))
    at = {"stage": [1, 3], "axial_stress": [1e5, 2e5], "mean_stress": [1e5, 2e5]}.get(test.control, [0.0, 0.002])
    described = json.loads(json.dumps(describe(experiment_of(test, test.control, at).check())))
    restored = restore(described)
    assert json.loads(json.dumps(describe(restored))) == described
    (model,) = (experiment.model for experiment in restored.experiments)
    assert type(model) is type(test) and model.control == test.control
    (ours,), (expected,) = (each.simulate([THETA], at=at, threads=1) for each in (model, test))
    assert all(np.array_equal(ours.values[name], values) for name, values in expected.values.items())


def description(test):
    return json.loads(json.dumps(describe(experiment_of(test, "axial_strain", [0.0, 0.1]))))["experiments"][0]["model"]


def test_a_test_is_described_by_what_is_in_effect(packing):
    # Campaigns are resumed by comparing: they are the same whether a default was written down or not, and other defaults of a later version change none.
    written = {
        "accuracy": "standard",
        "time_step_bound": "contact",
        "mass_exponent": 1.0,
        "precision": "float32",
        "rest_every": 0.004,
        "inertial_number": INERTIAL_NUMBER,
    }
    described = description(gc.TriaxialTest(packing, PRESSURE))
    assert described == description(gc.TriaxialTest(packing, PRESSURE, **written))
    assert {name: described[name] for name in written.keys() - {"accuracy"}} == {name: value for name, value in written.items() if name != "accuracy"}
    assert described != description(gc.TriaxialTest(packing, PRESSURE, accuracy="reference"))


def test_the_reference_accuracy_is_the_papers_protocol(packing):
    reference = gc.TriaxialTest(packing, PRESSURE, accuracy="reference")
    assert (reference.setting("time_step_bound"), reference.setting("mass_exponent"), reference.setting("precision")) == ("grain", 3.0, "float64")
    assert reference.economies == {"accuracy": "reference"} and gc.TriaxialTest(packing, PRESSURE).economies == {}
    # What is set by itself counts, and is named the shortest way.
    assert gc.TriaxialTest(packing, PRESSURE, accuracy="reference", precision="float32").setting("precision") == "float32"
    assert gc.TriaxialTest(packing, PRESSURE, precision="float64").economies == {"precision": "float64"}
    assert gc.TriaxialTest(packing, PRESSURE, time_step_bound="grain", mass_exponent=3, precision="float64").economies == {"accuracy": "reference"}


def test_what_saves_steps_is_described_and_restored(packing):
    options = {"time_step_bound": "grain", "mass_exponent": 2.0, "inertia_factor": 2.0, "settling_damping": 0.4, "strain_ramp": 0.1}
    described = json.loads(json.dumps(describe(experiment_of(gc.TriaxialTest(packing, PRESSURE, **options), "axial_strain", [0.0, 0.1]))))
    model = described["experiments"][0]["model"]
    assert {name: model[name] for name in options} == options
    (experiment,) = restore(described).experiments
    assert experiment.model.economies == options


def test_an_inertial_number_stands_for_a_density_scaling(packing):
    # I = strain rate * mean diameter * sqrt(density / pressure): the density for which it is the paper's is the paper's.
    inertial = 0.1 * 2 * packing.radii.mean() * np.sqrt(2650 * 1e3 / PRESSURE)
    same = gc.TriaxialTest(packing, PRESSURE, inertial_number=inertial)
    assert same.scaling == pytest.approx(gc.TriaxialTest(packing, PRESSURE, density_scaling=1e3).scaling, rel=1e-14)
    # Half of it is a quarter of the density; at four times the pressure, or half the size, it takes four times the density.
    assert gc.TriaxialTest(packing, PRESSURE, inertial_number=inertial / 2).scaling == pytest.approx(250, rel=1e-14)
    assert gc.TriaxialTest(packing, 4 * PRESSURE, inertial_number=inertial).scaling == pytest.approx(4000, rel=1e-14)
    small = gc.Packing(packing.positions / 2, packing.radii / 2, packing.edges / 2, packing.name)
    assert gc.TriaxialTest(small, PRESSURE, inertial_number=inertial).scaling == pytest.approx(4000, rel=1e-14)
    # A copy at another pressure has the same inertial number, and that is what is kept.
    assert replace(same, confining_pressure=4 * PRESSURE).scaling == pytest.approx(4000, rel=1e-14)
    assert description(same)["inertial_number"] == inertial and "density_scaling" not in description(same)


def test_the_default_inertial_number_is_that_of_the_papers_density_scaling_on_its_packing(reference_data):
    packing = gc.Packing.read(reference_data / "packing_1000.csv")
    assert gc.TriaxialTest(packing, 0.5e6).scaling == pytest.approx(1e3, rel=1e-2)


def test_a_table_without_consolidation_has_the_inertial_number_at_its_first_stresses(packing, table):
    driven = StressPathTable(tuple(replace(row, goals=tuple(replace(goal, stress=False, target=0.0) for goal in row.goals)) for row in table.rows))
    for path, pressure in ((table, 1e5), (driven, 0.5e6)):
        test = gc.TableTest(packing, table=path)
        assert test.scaling == pytest.approx(gc.TriaxialTest(packing, pressure).scaling, rel=1e-12)


def test_what_saves_steps_must_mean_something(packing, table):
    for options, words in [
        ({"inertial_number": 1e-3, "density_scaling": 10.0}, "density_scaling and inertial_number are both given"),
        ({"inertial_number": 0.0}, "inertial_number must be a positive number, not 0.0"),
        ({"accuracy": "high"}, "accuracy must be 'standard' or 'reference', not 'high'"),
        ({"inertial_number": 5.0}, "inertial_number must be from 1e-06 to 0.1, not 5"),
        ({"rest_every": 0.4e-5}, "rest_every must be a strain from 1e-05 to 0.05, a fraction and not percent, not 4e-06"),
        ({"rest_every": 0.4}, "rest_every must be a strain from 1e-05 to 0.05, a fraction and not percent, not 0.4"),
        ({"time_step_bound": "true"}, "time_step_bound must be 'grain' or 'contact', not 'true'"),
        ({"mass_exponent": 4.0}, "mass_exponent must be a number from 0 to 3, not 4.0"),
        ({"inertia_factor": 0.0}, "inertia_factor must be a number above 0, not 0.0"),
        ({"settling_damping": 1.0}, "settling_damping must be a number between 0 and 1, not 1.0"),
        ({"strain_ramp": 0.6}, "strain_ramp must be a number from 0 to 0.5, not 0.6"),
    ]:
        with pytest.raises(InputError, match=words):
            gc.TriaxialTest(packing, PRESSURE, **options)
    with pytest.raises(
        InputError, match="rest_every is a strain, and an isotropic test that is driven by mean_stress rests at states of its own: leave it out."
    ):
        gc.IsotropicTest(packing, PRESSURE, rest_every=0.002)


def test_a_reference_on_another_control_is_refused(packing, table):
    with pytest.raises(InputError, match="an oedometric test is driven by axial_strain, and its reference's control is axial_stress."):
        experiment_of(gc.OedometricTest(packing, PRESSURE), "axial_stress", [1e5, 2e5]).check()
    with pytest.raises(InputError, match="an undrained triaxial test is driven by axial_strain or axial_extension, not by volumetric_strain."):
        gc.UndrainedTest(packing, PRESSURE, control="volumetric_strain")
    with pytest.raises(InputError, match="values of mean_stress must be one row of numbers above 0"):
        gc.IsotropicTest(packing, PRESSURE).simulate([THETA], at=[0.0, 1e5])
    with pytest.raises(InputError, match="stages must be one row of the numbers of recorded ones, 1, 3."):
        experiment_of(gc.TableTest(packing, table=table), "stage", [1, 2]).check()
    with pytest.raises(InputError, match="confining_pressure must be a positive number, not None"):
        gc.OedometricTest(packing, None)


def test_a_default_stands_in_one_place():
    # What the command line and the calibration file leave out is what the test leaves out.
    of_the_test = {field.name: field.default for field in fields(TriaxialTest)}
    for options in (Simulation.__dataclass_fields__, StressPathModel.model_fields):
        shared = options.keys() & of_the_test.keys() - {"packing", "confining_pressure", "fixed"}
        assert shared >= {field.name for field in fields(Economy)}
        assert {name: options[name].default for name in shared} == {name: of_the_test[name] for name in shared}


def test_a_test_that_is_far_from_quasi_static_is_pointed_out(packing):
    fast = gc.TriaxialTest(packing, PRESSURE, inertial_number=0.05)
    assert unusual(fast) == ["the inertial number is 0.05; above 0.003 the grains' inertia changes the curve."]
    scaled = gc.TriaxialTest(packing, PRESSURE, density_scaling=fast.scaling)
    assert unusual(scaled) == unusual(fast) and scaled.density_in_words.endswith("an inertial number of 0.05")
    assert unusual(gc.TriaxialTest(packing, PRESSURE)) == []
