"""Calibrations on compression tests that load, unload and reload."""

import json
from dataclasses import replace

import numpy as np
import pytest

import graincal as gc
from graincal import demo
from graincal.campaign import Calibration
from graincal.campaign.asked.description import describe, restore
from graincal.campaign.file.experiments import ExperimentEntry
from graincal.campaign.found.runs import known_runs
from graincal.cli.comparison import Compared, driven_as, read_comparison
from graincal.cli.figures import draw_references
from graincal.cli.predict import predicted_test
from graincal.positions import POSITION, positions
from graincal.report.command import simulate_command
from graincal.result import Result

pytestmark = pytest.mark.usefixtures("fewer_draws")

PRESSURE, TURNS = 2e4, (1.6e5, 4e4)
STRESSES = [2e4, 4e4, 8e4, 1.6e5, 8e4, 4e4, 8e4, 1.6e5, 2.5e5]
AT = positions(STRESSES, PRESSURE)
FIXED = {"nu": 0.2, "beta_m": 0.1, "eta_m": 0.3}
TRUTH = {"log_E": 8.2, "phi": 30.0}
SPACE = gc.ParameterSpace({"log_E": (7.7, 8.7), "phi": (15, 45)})
FEW = {"first_batch": 10, "batch": 3, "packing_scatter": False}
ERRORS = {gc.OedometricTest: {"void_ratio": 3e-4, "lateral_stress": 2e3}, gc.IsotropicTest: {"void_ratio": 3e-4}}


def compared(file, test, experiment):
    """The test, driven as that of a file, and the file's reference."""
    test = driven_as(file, test)
    return test, read_comparison(file, Compared.of(test, experiment), experiment)


def cycle(kind=gc.OedometricTest, packing=None, pressure=PRESSURE, turns=TURNS, **options):
    return kind(packing or demo.packing(), pressure, control=POSITION, turns=turns, fixed=FIXED, **options)


def measured(kind=gc.OedometricTest):
    """The cycle at known parameters, on another packing."""
    (response,) = cycle(kind, demo.sibling()).simulate([list(TRUTH.values())], at=AT)
    return gc.Reference(AT, {name: response.values[name] for name in ERRORS[kind]}, measurement_errors=ERRORS[kind], control_name=POSITION)


def calibrate(kind, folder, **options):
    return gc.calibrate(cycle(kind), measured(kind), SPACE, folder=folder, seed=2, workers=1, **options)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign on an oedometer's cycle."""
    folder = tmp_path_factory.mktemp("cycle") / "oedometer"
    calibrate(gc.OedometricTest, folder, stop=gc.Stop(max_iterations=2, posterior_shift=0), **FEW)
    return folder


@pytest.mark.parametrize(("kind", "stress"), [(gc.OedometricTest, "axial stress σ"), (gc.IsotropicTest, "mean stress p")])
def test_a_cycle_is_calibrated_by_the_papers_method(tmp_path, kind, stress):
    never = gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=2)
    options = {"method": "iterative-bayesian", "alpha": 3}
    whole = calibrate(kind, tmp_path / "whole", stop=never, **options)
    calibrate(kind, tmp_path / "parts", stop=replace(never, max_iterations=1), **options)
    resumed = gc.resume(tmp_path / "parts", max_iterations=2)
    np.testing.assert_array_equal(whole.samples, resumed.samples)
    np.testing.assert_array_equal(whole.errors, resumed.errors)
    assert whole.failures == 0 and whole.best.error < 1
    assert stress in gc.Result.read(tmp_path / "whole").report(tmp_path / "report.html").read_text()


def test_a_cycle_of_isotropic_compression_has_a_posterior(tmp_path):
    result = calibrate(gc.IsotropicTest, tmp_path / "campaign", stop=gc.Stop(max_iterations=2, posterior_shift=0), **FEW)
    # It says how stiff grains are, and little else.
    assert abs(result.posterior.mean()[0] - TRUTH["log_E"]) < 0.1 and result.posterior.std()[0] < 0.1
    assert "mean stress p [kPa]" in result.report(tmp_path / "report.html").read_text()


def test_a_cycle_has_a_posterior_that_is_resumed_and_drawn(folder, tmp_path):
    result = Result.read(folder)
    assert result.failures == 0 and abs(result.posterior.mean()[0] - TRUTH["log_E"]) < 0.15
    response = result.response(result.best.sample, 0)
    assert response.control_name == POSITION and len(response.turns) == 2
    stopped = calibrate(gc.OedometricTest, tmp_path / "parts", stop=gc.Stop(max_iterations=1, posterior_shift=0), **FEW)
    assert stopped.evaluations < result.evaluations
    resumed = gc.resume(tmp_path / "parts", max_iterations=2)
    np.testing.assert_array_equal(resumed.samples, result.samples)
    np.testing.assert_array_equal(resumed.posterior.samples, result.posterior.samples)
    page = resumed.report(tmp_path / "report.html").read_text()
    assert "turns around at 160, 40 kPa of axial stress" in page


def test_a_hopeless_run_is_stopped_on_its_way():
    experiment = gc.Experiment("cycle", cycle(), measured())
    samples = gc.data.Samples(np.arange(1), np.array([list(TRUTH.values())]), SPACE.names)
    ((_, whole),), ((_, stopped),) = experiment.evaluate(samples), experiment.evaluate(samples, hopeless=lambda _, rows: len(rows) > 5)
    assert stopped.stopped and len(stopped.control) < len(whole.control)
    seen, expected = experiment.observables(stopped), experiment.observables(whole)
    rows = int(np.isfinite(seen[:, 0]).sum())
    assert 5 < rows < len(AT) and np.isnan(seen[rows:]).all()
    np.testing.assert_array_equal(seen[:rows], expected[:rows])


def test_curves_of_a_cycle_are_drawn_over_the_logarithm_of_its_stress(folder, tmp_path, monkeypatch):
    from matplotlib.figure import Figure

    from graincal.campaign.found.emulated import Emulated
    from graincal.report.emulated_figures import draw_bands
    from graincal.report.responses import control_axis

    result = Result.read(folder)
    axis, x = control_axis(result.experiments[0])
    assert axis.log and axis.label == "axial stress σ_{1} [kPa]"
    np.testing.assert_allclose(x, np.array(STRESSES) / 1e3, rtol=1e-9)
    drawn = draw_bands(Emulated.of(result)).panels[0]
    # A band for each leg: one that folds over would have holes.
    widths = [mark for mark in drawn.marks if mark.name == "90 % of measurements"]
    assert len(widths) == 3 and all(len(set(np.sign(np.diff(mark.x)))) == 1 for mark in widths)
    (line,) = [mark for mark in drawn.marks if mark.name == "runs at the answer"][:1]
    assert line.x.max() > 250 and line.x[8] == pytest.approx(160)
    saved = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: saved.append(figure))
    draw_references(result.experiments, tmp_path / "references.png")
    axes = saved[0].axes[0]
    assert axes.get_xscale() == "log" and axes.get_xlabel() == "axial stress (kPa)"
    np.testing.assert_allclose(axes.lines[0].get_xdata(), np.array(STRESSES) / 1e3, rtol=1e-9)


def test_a_cycle_is_predicted_at_its_own_and_another_pressure(call, folder, tmp_path):
    called = call("predict", folder, "--samples", "3", "--plot", tmp_path / "band.png", "-o", tmp_path / "band.csv")
    assert called.code == 0 and (tmp_path / "band.png").exists(), called.err
    np.testing.assert_allclose(np.genfromtxt(tmp_path / "band.csv", delimiter=",", names=True)["position"], AT, atol=1e-8)
    # The turns stay, and so do the stresses of the rows, but for those that the path no longer comes by.
    called = call("predict", folder, "--samples", "3", "--confining-pressure", "3e4", "-o", tmp_path / "other.csv")
    found = np.genfromtxt(tmp_path / "other.csv", delimiter=",", names=True)
    assert called.code == 0
    np.testing.assert_allclose(cycle(pressure=3e4).stress_at(found["position"]), STRESSES[1:], rtol=1e-6)
    called = call("predict", folder, "--samples", "3", "--confining-pressure", "2e5")
    assert called.code == 1 and 'below 160000 Pa was expected, to which the path of "experiment" goes first' in " ".join(called.err.split())


FILE = """
[parameters]
phi = {{ range = [15, 45] }}
[[experiment]]
name        = "other"
control     = "{control}"
observables = {{ {observable} = {{}} }}
model       = {{ kind = "{kind}", packing = "packing.csv", confining_pressure = 20e3{turns} }}
reference   = {{ file = "lab.csv", units = {{ {units} }}, strain = "logarithmic" }}
"""


def test_a_test_is_compared_as_its_calibration_file_drives_it(folder, tmp_path):
    experiment, file = Result.read(folder).experiments[0], tmp_path / "other.toml"
    (tmp_path / "lab.csv").write_text("axial_stress,void_ratio\n20,0.67\n60,0.66\n30,0.665\n60,0.66\n")
    file.write_text(
        FILE.format(control=POSITION, observable="void_ratio", kind="oedometric", turns=", turns = [60e3, 30e3]", units='axial_stress = "kPa"').replace(
            ', strain = "logarithmic"', ""
        )
    )
    test, reference = compared(file, cycle(), experiment)
    assert (test.control, test.turns) == (POSITION, (6e4, 3e4)) and len(reference.control) == 4
    test, _ = compared(file, gc.OedometricTest(demo.packing(), PRESSURE, fixed=FIXED, rest_every=0.01), experiment)
    assert (test.control, test.turns, test.rest_every) == (POSITION, (6e4, 3e4), None)
    triaxial = gc.TriaxialTest(demo.packing(), PRESSURE, fixed=FIXED)
    with pytest.raises(gc.InputError, match="a triaxial experiment was expected, to compare a triaxial test with, and there is none"):
        compared(file, triaxial, experiment)
    # A test in extension, for a campaign in compression.
    (tmp_path / "lab.csv").write_text("axial_strain,volumetric_strain\n0,0\n-0.01,-0.002\n")
    file.write_text(FILE.format(control="axial_extension", observable="volumetric_strain", kind="triaxial", turns="", units=""))
    test, reference = compared(file, triaxial, experiment)
    assert test.control == reference.control_name == "axial_extension" and reference.control[-1] == pytest.approx(0.01)
    # And one that its path does not return.
    file.write_text(file.read_text().replace("volumetric_strain", "porosity"))
    (tmp_path / "lab.csv").write_text("axial_strain,porosity\n0,0.4\n-0.01,0.41\n")
    with pytest.raises(gc.InputError, match="a triaxial test returns axial_strain, .* and the reference holds porosity"):
        compared(file, triaxial, experiment)


def test_another_path_has_no_turns(folder):
    experiment = Result.read(folder).experiments[0]
    test = predicted_test(experiment, "triaxial", 1e5)
    assert test.kind == "triaxial" and not hasattr(test, "turns")
    isotropic = gc.Experiment("isotropic", cycle(gc.IsotropicTest), measured(gc.IsotropicTest))
    assert predicted_test(isotropic, "oedometric", None).turns == ()


def test_the_command_that_simulates_a_cycle_again_turns_where_it_does(folder):
    result = Result.read(folder)
    test, samples = result.experiments[0].model, gc.data.Samples(np.arange(1), np.array([[8.2, 30.0]]), SPACE.names)
    coarse = gc.Reference(positions([2e4, 5e4, 1e5, 2e5], PRESSURE)[:3], {"void_ratio": [0.6, 0.6, 0.6]}, control_name=POSITION)
    assert "--axial-stress 50000 --axial-stress 100000 -o" in simulate_command(test, samples, coarse)
    across = gc.Reference([np.log(4), np.log(8) + np.log(2), AT[-1]], {"void_ratio": [0.6, 0.6, 0.6]}, control_name=POSITION)
    stresses = [float(word) for word in simulate_command(test, samples, across).split() if word.replace(".", "").isdigit()]
    assert [8e4, 1.6e5, 8e4, 4e4, 2.5e5] == [stress for stress in stresses if stress > 2.5e4]
    every = simulate_command(test, samples, result.experiments[0].reference)
    assert every.count("--axial-stress") == len(STRESSES) - 1


def described(test, reference):
    return json.loads(json.dumps(describe(Calibration(SPACE, [gc.Experiment("cycle", test, reference)]))))


def test_turns_are_part_of_what_is_asked():
    reference = measured()
    known = described(cycle(), reference)
    restored = restore(known)
    assert known["experiments"][0]["model"]["turns"] == list(TURNS) and restored.experiments[0].model.turns == TURNS
    assert described(restored.experiments[0].model, reference) == known
    assert described(cycle(turns=(1.6e5, 3e4)), reference) != known
    # Where there are none nothing is said of them.
    assert "turns" not in described(cycle(turns=()), reference)["experiments"][0]["model"]


def test_runs_serve_the_same_cycle_in_units_of_its_pressure(tmp_path):
    folder = gc.explore(cycle(), SPACE, to=AT[-1] + 0.1, folder=tmp_path / "library", observables=("void_ratio",), runs=4, workers=1)
    reference = gc.Reference(AT, {"void_ratio": np.linspace(0.66, 0.65, len(AT))}, control_name=POSITION)
    # A sevenfold pressure: its quotients end in other digits.
    space = gc.ParameterSpace({"log_E": (7.7 + np.log10(7), 8.7 + np.log10(7)), "phi": (15, 45)})
    elsewhere = cycle(pressure=7 * PRESSURE, turns=[7 * turn for turn in TURNS])
    runs = known_runs([folder], Calibration(space, [gc.Experiment("other", elsewhere, reference)]))
    assert len(runs) == 4
    own = elsewhere.simulate(runs.theta[:1], AT, threads=1)[0]
    np.testing.assert_allclose(runs.responses[0][0], own.observables(("void_ratio",)), atol=2e-4)
    for turns in (TURNS, [7 * TURNS[0]], ()):
        with pytest.raises(gc.InputError, match="they differ in turns in units of the confining pressure;"):
            known_runs([folder], Calibration(space, [gc.Experiment("other", replace(elsewhere, turns=turns), reference)]))


def entry(**changes):
    model = {"kind": "oedometric", "packing": "packing.csv", "confining_pressure": PRESSURE, "turns": list(TURNS)}
    return {"name": "cycle", "reference": "cycle.csv", "control": POSITION, "observables": {"void_ratio": {}}, "model": model} | changes


def test_a_calibration_file_says_where_a_path_turns(tmp_path, monkeypatch):
    demo.packing().write(tmp_path / "packing.csv")
    asked = {}
    monkeypatch.setattr(gc.Reference, "read", lambda path, control, observables, **options: asked.update(options, control=control) or measured())
    experiment = ExperimentEntry.model_validate(entry()).build(tmp_path)
    assert experiment.model.turns == TURNS and experiment.model.control == POSITION
    # Positions start from it.
    assert asked["confining_pressure"] == PRESSURE and asked["control"] == POSITION
    with pytest.raises(gc.InputError, match='experiment "cycle": turns are those of a path whose control is position, and this one\'s is axial_strain'):
        ExperimentEntry.model_validate(entry(control="axial_strain")).build(tmp_path)
    isotropic = ExperimentEntry.model_validate(entry(model=entry()["model"] | {"kind": "isotropic"}))
    assert isotropic.build(tmp_path).model.turns == TURNS
    for turns in ([0.0], [1e5, -1.0], 1e5):
        with pytest.raises(ValueError, match="turns"):
            ExperimentEntry.model_validate(entry(model=entry()["model"] | {"turns": turns}))
    with pytest.raises(ValueError, match="turns"):
        ExperimentEntry.model_validate(entry(model=entry()["model"] | {"kind": "triaxial"}))
