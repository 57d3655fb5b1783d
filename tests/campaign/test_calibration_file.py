"""calibration.toml: what it says is what is calibrated, and each mistake in it is one sentence with file, key and expectation."""

from pathlib import Path

import numpy as np
import pytest

from graincal import Experiment, InputError, Packing, ParameterSpace, TriaxialTest, demo
from graincal.campaign import Calibration
from graincal.campaign.file.config import read_calibration
from graincal.campaign.stored.store import Store
from graincal.cli.comparison import Compared, read_comparison
from graincal.data import MeasurementError
from graincal.inference import PosteriorFilter

from .hyperbola import STRAIN, THE_PAPERS, reference, write_calibration

ENTRY = 'model       = { kind = "python", function = "soil:respond" }'
SHARES = "{ stress_ratio = { variance_share = 0.5 }, volumetric_strain = { variance_share = 0.5 } }"


def test_a_file_says_all_that_is_calibrated(tmp_path):
    calibration = read_calibration(write_calibration(tmp_path, ("= 3\n", "= 4\n"), ("{ variance_share = 0.5 } }", "{ variance_share = 0.8 } }")))
    assert calibration.space.names == ("strength", "dilatancy") and calibration.space.units == ("", "-")
    (experiment,) = calibration.experiments
    assert experiment.name == "drained" and experiment.reference.variance_shares == {"stress_ratio": 0.5, "volumetric_strain": 0.8}
    np.testing.assert_array_equal(experiment.reference.control, STRAIN)
    assert (calibration.method, dict(calibration.filter_options), calibration.seed, calibration.workers) == ("iterative-bayesian", {"alpha": 10}, 4, 1)
    assert calibration.stop.max_iterations == 4 and calibration.stop.s is False and calibration.stop.max_evaluations is False


def test_a_time_out_is_kept_with_the_campaign(tmp_path):
    calibration = read_calibration(write_calibration(tmp_path, ('"soil:respond"', '"soil:respond", timeout = 90')))
    assert calibration.experiments[0].model.timeout == 90
    assert Store.create(calibration).calibration.experiments[0].model.timeout == 90


def test_sections_that_are_left_out_have_their_defaults(tmp_path):
    path = write_calibration(tmp_path)
    path.write_text(path.read_text().split("[filter]")[0])
    calibration = read_calibration(path)
    assert calibration.method == "posterior" and calibration.stop.posterior_shift == 0.2 and calibration.stop.max_iterations is None
    assert calibration.seed == 1 and calibration.workers == "all" and len(calibration.new_filter().ask()) == 8
    path.write_text(path.read_text() + '[filter]\nmethod = "iterative-bayesian"\n')
    calibration = read_calibration(path)
    assert calibration.stop.s == 0.01 and calibration.new_filter().samples_per_iteration == 20


def test_measurement_errors_are_kept_in_a_laboratory_s_terms(tmp_path):
    errors = "{ stress_ratio = { measurement_error = 0.02, relative_error = 0.01 }, volumetric_strain = { step = 1e-4 } }"
    path = write_calibration(tmp_path, (SHARES, errors), ('"reference.csv"', '{ file = "reference.csv", control_step = 1e-3, simulated = true }'))
    given = read_calibration(path)
    for calibration in (given, Store.create(given).calibration):
        reference = calibration.experiments[0].reference
        assert reference.measurement_errors == {"stress_ratio": MeasurementError(0.02, 0.01), "volumetric_strain": MeasurementError(step=1e-4)}
        assert reference.control_step == 1e-3 and reference.simulated


def test_a_reference_is_compared_until_a_strain_and_kept_so(tmp_path):
    given = read_calibration(write_calibration(tmp_path, ('"reference.csv"', '{ file = "reference.csv", until = 0.1 }')))
    for calibration in (given, Store.create(given).calibration):
        reference = calibration.experiments[0].reference
        np.testing.assert_array_equal(reference.control, STRAIN[STRAIN <= 0.1])
        assert reference.notes[0] == "5 rows left out beyond until = 0.1, where axial_strain goes on to 0.2: lines 8-12."


def test_the_posterior_has_its_own_keys(tmp_path):
    keys = 'method = "posterior"\nfirst_batch = 12\nbatch = 6\ncorrelation_length = 0.1\ndiscrepancy = true'
    given = read_calibration(write_calibration(tmp_path, (THE_PAPERS, keys), ("= 3\ns", "= 3\nposterior_shift = 0.1\ns")))
    for calibration in (given, Store.create(given).calibration):
        filter = calibration.new_filter()
        assert isinstance(filter, PosteriorFilter) and (len(filter.ask()), filter.batch, filter.stop.posterior_shift) == (12, 6, 0.1)
        # One length, three discrepancies.
        assert filter.errors[0].size == 3


def test_a_triaxial_test_reads_its_packing_beside_the_file(tmp_path):
    path = write_triaxial(tmp_path)
    (experiment,) = read_calibration(path).experiments
    assert isinstance(experiment.model, TriaxialTest)
    assert experiment.model.confining_pressure == 2e5 and experiment.model.fixed == {"nu": 0.2, "beta_m": 0.1, "eta_m": 0.1}
    assert experiment.model.packing.count == 27 and experiment.model.density_scaling is None


def test_what_saves_steps_is_chosen_by_keys(tmp_path):
    keys = "inertial_number = 1e-3, rest_every = 0.01, accuracy = 'reference', mass_exponent = 1, inertia_factor = 2, settling_damping = 0.4, strain_ramp = 0.1"
    (experiment,) = read_calibration(write_triaxial(tmp_path, ("confining_pressure = 2e5,", f"confining_pressure = 2e5, {keys},"))).experiments
    options = {"time_step_bound": "grain", "precision": "float64", "mass_exponent": 1.0, "inertia_factor": 2.0, "settling_damping": 0.4, "strain_ramp": 0.1}
    assert experiment.model.settings == options and experiment.model.rest_every == 0.01
    # I = 0.1 /s * 2.0002 mm * sqrt(2650 kg/m^3 * scaling / 200 kPa)
    assert experiment.model.scaling == pytest.approx(2e5 * (1e-3 / (0.1 * 2.0002e-3)) ** 2 / 2650, rel=1e-12)


def test_the_contact_law_is_chosen_by_name(tmp_path):
    named = ("confining_pressure = 2e5,", 'confining_pressure = 2e5, law = "hertz-mindlin",')
    (experiment,) = read_calibration(write_triaxial(tmp_path, named)).experiments
    assert experiment.model.law == "hertz-mindlin"
    with pytest.raises(InputError, match='law must be "linear" or "hertz-mindlin", not "hertz"'):
        read_calibration(write_triaxial(tmp_path, (named[0], 'confining_pressure = 2e5, law = "hertz",')))


def test_the_precision_is_chosen_by_name(tmp_path):
    named = ("confining_pressure = 2e5,", 'confining_pressure = 2e5, precision = "float32",')
    (experiment,) = read_calibration(write_triaxial(tmp_path, named)).experiments
    assert experiment.model.precision == "float32"
    with pytest.raises(InputError, match='precision must be "float64" or "float32", not "single"'):
        read_calibration(write_triaxial(tmp_path, (named[0], 'confining_pressure = 2e5, precision = "single",')))


def write_triaxial(folder, *replacements):
    model = '{ kind = "triaxial", packing = "cubic.csv", confining_pressure = 2e5, fixed = { nu = 0.2, beta_m = 0.1, eta_m = 0.1 } }'
    renamed = [("strength  = { range = [0, 1] }", "log_E = { range = [7, 9] }"), ('dilatancy = { range = [0, 1], unit = "-" }', "phi = { range = [10, 40] }")]
    path = write_calibration(folder, *renamed, (ENTRY, f"model = {model}"), *replacements)
    grid = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * 2e-3
    rows = [f"{x},{y},{z},1.0001e-3" for x, y, z in grid]
    (folder / "cubic.csv").write_text("\n".join(["# simple cubic; cell lengths: 6e-3 6e-3 6e-3", "x,y,z,radius", *rows]) + "\n")
    return path


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (
            "alpha = 10",
            "alhpa = 10",
            'filter.alhpa is not a key that is known here (did you mean "alpha"?), and one of method, alpha, effective_sample_size, scale, covariance, first_batch, batch, ahead, early_stop, thin, correlation_length, discrepancy, packing_scatter, first_look, runs was expected.',
        ),
        (
            THE_PAPERS,
            "alpha = 10",
            'filter.alpha is an option of method = "iterative-bayesian", and with "posterior", the default, one of first_batch, batch, ahead, early_stop, thin, correlation_length, discrepancy, packing_scatter was expected.',
        ),
        (
            "alpha = 10",
            "batch = 10",
            'filter.batch is an option of method = "posterior", and with "iterative-bayesian" one of alpha, effective_sample_size, scale, covariance, thin was expected.',
        ),
        (
            THE_PAPERS + "\n\n[stop]\nmax_iterations = 3\ns = false",
            "\n[stop]\ns = 0.01",
            'stop.s is a criterion of method = "iterative-bayesian", and "posterior", the default, looks at posterior_shift, max_iterations, max_evaluations, hours.',
        ),
        ("alpha = 10", "workers = 2", "filter.workers is not a key that is known here, it belongs under [run]."),
        ("[stop]\n", "[stop]\nthin = true\n", "stop.thin is not a key that is known here, it belongs under [filter]."),
        ("[stop]\n", "[stop]\nuntil = 0.1\n", "stop.until is not a key that is known here, it belongs under [experiment.reference]."),
        (
            'name        = "drained"',
            'name = "drained"\nuntil = 0.1',
            'experiment "drained": until is not a key that is known here, it belongs under [experiment.reference].',
        ),
        (
            '"reference.csv"',
            '{ file = "reference.csv", until = -1 }',
            'experiment "drained": reference.until must be the last value of the control that is compared, above 0, a fraction for strains, in Pa for stresses, not -1.',
        ),
        (
            '"reference.csv"',
            '{ file = "reference.csv", until = "0.1" }',
            'experiment "drained": reference.until must be the last value of the control that is compared, above 0, a fraction for strains, in Pa for stresses, not "0.1".',
        ),
        (
            '"reference.csv"',
            '{ file = "reference.csv", until = inf }',
            'experiment "drained": reference.until must be the last value of the control that is compared, above 0, a fraction for strains, in Pa for stresses, not Infinity.',
        ),
        (
            '"reference.csv"',
            '{ file = "reference.csv", untill = 0.1 }',
            'experiment "drained": reference.untill is not a key that is known here (did you mean "until"?), and one of file, columns, units, strain, compression, unloading, until, confining_pressure, control_step, simulated, stage, rows, zero, sample_volume, sample_height, sheet, encoding was expected.',
        ),
        (
            '"reference.csv"',
            '{ file = "reference.csv", until = 10 }',
            'experiment "drained": {folder}/reference.csv: until = 10 leaves nothing out, where axial_strain goes to 0.2, and a fraction was expected; if 10 % is meant, write 0.1.',
        ),
        (
            '"reference.csv"',
            '{ file = "reference.csv", until = 0.01 }',
            'experiment "drained": {folder}/reference.csv: until = 0.01 leaves a single row, where axial_strain goes from 0 to 0.2, and one that leaves at least two was expected.',
        ),
        ("alpha = 10", "batch = 1", "filter.batch must be a whole number above 1, not 1."),
        ("alpha = 10", "early_stop = 1", "filter.early_stop must be true or false, not 1."),
        (
            "s = false",
            "s = false\nposterior_shift = 0.1",
            'stop.posterior_shift is a criterion of method = "posterior", and "iterative-bayesian" looks at s, gl_error_increment, error, error_increment, max_iterations, max_evaluations, hours.',
        ),
        (
            "{ variance_share = 0.5 } }",
            "{ variance_share = 0.5, relative_error = 0 } }",
            'experiment "drained": observables.volumetric_strain.relative_error must be a standard deviation above 0 as a part of each value, not 0.',
        ),
        ("alpha = 10", "alpha = 'ten'", 'filter.alpha must be a number above 0, not "ten".'),
        ("alpha = 10", "alpha = true", "filter.alpha must be a number above 0, not true."),
        ("alpha = 10", "alpha = 0.1", "filter.alpha = 0.1 leaves 0 samples for 2 parameter(s), and at least 2 are needed."),
        (
            "[filter]",
            "[filters]",
            'filters is not a key that is known here (did you mean "filter"?), and one of parameters, constraint, experiment, filter, first_look, stop, run was expected.',
        ),
        ("range = [0, 1] }", "range = [1, 0] }", "parameters.strength.range must be [low, high] with low < high, not [1.0, 0.0]."),
        ("range = [0, 1] }", "range = [0, nan] }", "parameters.strength.range must be [low, high] with low < high, not [0, NaN]."),
        ("{ range = [0, 1] }", "3", "parameters.strength must be a table, { fixed = 3 } for a value that is known or { range = [low, high] }, not 3."),
        ('name        = "drained"', "", "experiment 1: name is missing, and text was expected."),
        (
            ENTRY,
            "",
            'experiment "drained": model is missing, and a table whose kind is one of triaxial, oedometric, isotropic, undrained, constant-mean-stress, table, python, command, yade, by-hand was expected.',
        ),
        (
            '"python"',
            '"lammps"',
            'experiment "drained": model.kind must be one of triaxial, oedometric, isotropic, undrained, constant-mean-stress, table, python, command, yade, by-hand, not "lammps".',
        ),
        (
            '"python"',
            '"triaxal"',
            'experiment "drained": model.kind must be one of triaxial, oedometric, isotropic, undrained, constant-mean-stress, table, python, command, yade, by-hand, not "triaxal" (did you mean "triaxial"?).',
        ),
        ('"soil:respond"', '"soil:respond", timeout = 0', 'experiment "drained": model.timeout must be a number of seconds above 0, not 0.'),
        ("soil:respond", "soil", 'experiment "drained": function must be named as "module:name", not "soil".'),
        ("reference.csv", "no.csv", 'experiment "drained": {folder}/no.csv: there is no such file, and a laboratory file was expected here.'),
        (SHARES, "{}", 'experiment "drained": observables must be a table such as { stress_ratio = { variance_share = 0.5 } }, not {}.'),
        (
            "{ variance_share = 0.5 } }",
            "{} }",
            'experiment "drained": observables have a variance_share for some, and one for volumetric_strain too was expected.',
        ),
        (
            "{ variance_share = 0.5 } }",
            "{ variance_share = 0 } }",
            'experiment "drained": observables.volumetric_strain.variance_share must be a number above 0, the smaller the more trusted, not 0.',
        ),
        ("s = false", "s = true", "stop.s must be a number, not negative, or false, not true."),
        ("= 3\ns", "= 2.5\ns", "stop.max_iterations must be a whole number above 0, or false, not 2.5."),
        ("= 3\ns", "= 0\ns", "stop.max_iterations must be a whole number above 0, or false, not 0."),
        ("= 3\ns", "= false\ns", "stop: every criterion is switched off, so that nothing would end the calibration."),
        ("= 3\ns", "= 3\nmax_evaluations = 5\ns", "stop.max_evaluations = 5 does not hold one iteration of 20 samples: raise it, or lower filter.alpha."),
        ("workers = 1", "workers = 0", 'run.workers must be a whole number above 0, or "all", not 0.'),
        ("seed = 3", "seed = -3", "run.seed must be a whole number, not negative, not -3."),
        ("alpha = 10", "alpha =", "this is not TOML, Invalid value (at line 14, column 8)."),
    ],
)
def test_a_mistake_is_one_sentence_that_names_file_key_and_expectation(tmp_path, old, new, sentence):
    path = write_calibration(tmp_path, (old, new))
    with pytest.raises(InputError) as error:
        read_calibration(path)
    assert str(error.value) == f"{path}: {sentence.replace('{folder}', str(tmp_path))}"


def test_several_mistakes_are_said_together(tmp_path):
    path = write_calibration(tmp_path, ("alpha = 10", "alpha = 0"), ("workers = 1", "workers = 0"))
    with pytest.raises(InputError) as error:
        read_calibration(path)
    assert [line.split(": ")[1].split()[0] for line in str(error.value).splitlines()] == ["filter.alpha", "run.workers"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "confining_pressure = 2e5",
            "confining_presure = 2e5",
            'experiment "drained": model.confining_presure is not a key that is known here (did you mean "confining_pressure"?), and one of',
        ),
        (
            "confining_pressure = 2e5",
            "confining_pressure = 2e5, law = 'hertz-midlin'",
            'model.law must be "linear" or "hertz-mindlin", not "hertz-midlin" (did you mean "hertz-mindlin"?).',
        ),
        (
            "phi = { range = [10, 40] }",
            "phi_ = { range = [10, 40] }",
            'once, as a parameter or fixed: phi_ is not one of them (did you mean "phi"?); phi is missing.',
        ),
        (
            "stress_ratio = {",
            "stres_ratio = {",
            'stres_ratio is not an observable of a triaxial test (did you mean "stress_ratio"?), which gives axial_strain, ',
        ),
        (
            "stress_ratio = {",
            "q = {",
            'experiment "drained": q is not an observable of a triaxial test (did you mean "stress_ratio"?), which gives axial_strain, ',
        ),
        ("phi = { range = [10, 40] }", "psi = { range = [10, 40] }", 'experiment "drained": a triaxial test needs each of log_E, nu, phi, beta_m, eta_m once'),
        ('packing = "cubic.csv"', 'packing = "cubic.csv", seed = 1', 'experiment "drained": model has both packing and seed, and one of them was expected'),
        ('packing = "cubic.csv"', "particles = 500", 'experiment "drained": model needs either packing, the name of a file, or particles and void_ratio'),
        (
            "confining_pressure = 2e5",
            "confining_pressure = 2e5, density_scaling = 10, inertial_number = 1e-3",
            'experiment "drained": model has both density_scaling and inertial_number, and one of them was expected',
        ),
        (
            "confining_pressure = 2e5",
            "confining_pressure = 2e5, time_step_bound = 'pair'",
            'experiment "drained": model.time_step_bound must be "grain" or "contact", not "pair".',
        ),
        (
            "confining_pressure = 2e5",
            "confining_pressure = 2e5, mass_exponent = 4",
            'experiment "drained": model.mass_exponent must be a number from 0 to 3, not 4.',
        ),
        ("confining_pressure = 2e5", "confining_pressure = -1", 'experiment "drained": model.confining_pressure must be a number above 0, in Pa, not -1.'),
        (
            "confining_pressure = 2e5",
            "confining_pressure = 0.2",
            "confining_pressure is 0.2 Pa, and 1 to 1e+12 Pa was expected; if 0.2 MPa is meant, write 200000.",
        ),
        (
            "fixed = { nu = 0.2",
            "fixed = { log_E = 5e8, nu = 0.2",
            "fixed.log_E must be a number at least 0 and below 20, not 500000000.0; for a modulus of 5e+08 Pa write 8.699.",
        ),
        (
            "range = [10, 40]",
            "range = [10, 120]",
            "parameters.phi.range must hold numbers at least 0 and below 90, where the contact law means something, not [10, 120].",
        ),
        (
            "range = [10, 40]",
            "range = [-1, 40]",
            "parameters.phi.range must hold numbers at least 0 and below 90, where the contact law means something, not [-1, 40].",
        ),
        (
            "phi = { range = [10, 40] }",
            'phi = { range = [0.1, 1], unit = "rad" }',
            'parameters.phi.unit must be "deg" or left out, in which the contact law takes phi, not "rad"',
        ),
        (
            "log_E = { range = [7, 9] }",
            'log_E = { range = [-2, 0], unit = "log10 GPa" }',
            'parameters.log_E.unit must be "log10 Pa" or left out, in which the contact law takes log_E, not "log10 GPa"',
        ),
        (
            "range = [7, 9]",
            "range = [1e7, 1e11]",
            "parameters.log_E.range must hold numbers at least 0 and below 20, the log10 of the modulus in Pa, not [1e+07, 1e+11]; for a modulus of 1e+07 to 1e+11 Pa write [7, 11].",
        ),
        (
            "range = [7, 9]",
            "range = [-5, 21]",
            "parameters.log_E.range must hold numbers at least 0 and below 20, the log10 of the modulus in Pa, not [-5, 21].",
        ),
        (
            '"drained"',
            '"drained"\ncontrol = "volumetric_strain"',
            'experiment "drained": a triaxial test is driven by axial_strain or axial_extension, not by volumetric_strain.',
        ),
    ],
)
def test_mistakes_about_a_triaxial_test(tmp_path, old, new, said):
    path = write_triaxial(tmp_path, (old, new))
    with pytest.raises(InputError) as error:
        read_calibration(path)
    assert str(error.value).startswith(f"{path}: ") and said in str(error.value) and "\n" not in str(error.value)


def test_no_other_contact_parameter_is_below_zero():
    triaxial = TriaxialTest(Packing.read(Path(demo.__file__).with_name("packing_500.csv")), 1e5)
    for name in ("nu", "beta_m", "eta_m"):
        ranges = {"log_E": (7, 11), "nu": (0, 0.5), "phi": (0, 60), "beta_m": (0, 1), "eta_m": (0, 1)} | {name: (-1, 1)}
        with pytest.raises(InputError, match=f"parameters.{name}.range must hold numbers at least 0, .* not \\[-1, 1\\]"):
            Calibration(ParameterSpace(ranges), [Experiment("x", triaxial, reference())]).check()


def test_a_single_state_is_no_curve(tmp_path):
    path = write_calibration(tmp_path)
    (tmp_path / "reference.csv").write_text("axial_strain,stress_ratio,volumetric_strain\n0.1,2,0\n")
    with pytest.raises(InputError, match='experiment "drained": its reference holds a single state, and a curve of at least two was expected'):
        read_calibration(path)


def test_what_is_no_file_is_said(tmp_path):
    with pytest.raises(InputError, match="there is no such file, and a calibration file was expected here"):
        read_calibration(tmp_path / "none.toml")


def test_a_simulation_is_compared_with_the_reference_at_its_confining_pressure(tmp_path):
    # The file's column is q, made a stress ratio with the model's pressure; two experiments differ by that alone.
    path = write_triaxial(
        tmp_path,
        ('"reference.csv"', '{ file = "q.csv", columns = { deviator_stress = "q" }, units = { deviator_stress = "kPa" } }'),
        (SHARES, "{ stress_ratio = {} }"),
    )
    (tmp_path / "q.csv").write_text("axial_strain,q\n0,0\n0.1,100\n")
    first = path.read_text().split("[[experiment]]")[1].split("[filter]")[0]
    second = first.replace('"drained"', '"denser"').replace("2e5", "1e5")
    path.write_text(path.read_text().replace("[filter]", f"[[experiment]]{second}[filter]"))
    assert [read_comparison(path, Compared.drained(pressure)).observables["stress_ratio"][-1] for pressure in (1e5, 2e5)] == [2.0, 1.5]
    with pytest.raises(
        InputError, match='one experiment at the confining pressure of 300000 Pa was expected, and there are "drained" at 200000 Pa, "denser" at 100000 Pa'
    ):
        read_comparison(path, Compared.drained(3e5))
    path.write_text(path.read_text().replace("2e5", "1e5"))
    with pytest.raises(InputError, match="one experiment at the confining pressure of 100000 Pa was expected"):
        read_comparison(path, Compared.drained(1e5))


def test_a_reference_that_a_triaxial_test_does_not_return_is_no_comparison(tmp_path):
    (tmp_path / "lab.csv").write_text("axial_strain,porosity\n0,0.4\n0.1,0.4\n")
    path = write_calibration(tmp_path, ('"reference.csv"', '"lab.csv"'), (SHARES, "{ porosity = {} }"))
    with pytest.raises(InputError, match="a triaxial test returns axial_strain, .* and the reference holds porosity"):
        read_comparison(path, Compared.drained(1e5))
