"""Runs that somebody makes by hand: what waits is asked for, what was made is told, and the campaign finds what it would have found by itself."""

import csv
import io
import json
import shutil
import subprocess

import numpy as np
import pytest

import graincal as gc
from graincal import demo
from graincal.campaign.found.status import status
from graincal.campaign.run.asking import as_yade_table, ask
from graincal.campaign.run.telling import tell
from graincal.campaign.run.waiting import RunsWait
from graincal.campaign.stored.log import Log
from graincal.campaign.stored.store import Store
from graincal.interpolation import interpolate
from graincal.models import ByHandModel
from graincal.models.output import Column, Output

from .as_tasks import broken_off
from .hyperbola import SPACE, STRAIN, THE_PAPERS, reference, respond, write_calibration
from .test_campaign import assert_same

FUNCTION, BY_HAND = 'kind = "python", function = "soil:respond"', 'kind = "by-hand"'
TWO = ("max_iterations = 3", "max_iterations = 2")
POSTERIOR = (THE_PAPERS, 'method = "posterior"\nfirst_batch = 8\nbatch = 4')
NO_CRITERIA = ("s = false\ngl_error_increment = false\nerror = false\nerror_increment = false\n", "")


def write_curve(path, values, control=STRAIN):
    rows = zip(control, *values.values())
    path.write_text("\n".join([",".join(["axial_strain", *values]), *(",".join(repr(float(cell)) for cell in row) for row in rows)]) + "\n")


def make(asked, folder, function=respond):
    """What somebody does with a table of parameters: a curve for each, or a reason."""
    folder.mkdir(exist_ok=True)
    for row in csv.DictReader(io.StringIO(asked)):
        try:
            write_curve(folder / f"{row['id']}.csv", function(np.array([float(row[name]) for name in SPACE.names])))
        except ArithmeticError as error:
            (folder / f"{row['id']}.failed").write_text(f"ArithmeticError: {error}.\n")
    return folder


def by_hand(call, campaign, folder):
    """Make and tell what waits, until the campaign is at its end; how often that was."""
    for turn in range(20):
        asked = call("ask", campaign)
        if asked.code:
            assert "at its end" in asked.err
            return turn
        told = call("tell", campaign, make(asked.out, folder / f"runs {turn}"))
        assert told.code == 0 and told.err == "", told.err
    raise AssertionError("it does not end")


@pytest.fixture
def begun(call, tmp_path):
    """A campaign whose first batch waits."""
    called = call("calibrate", write_calibration(tmp_path, TWO, (FUNCTION, BY_HAND)), "-o", tmp_path / "campaign")
    assert called.code == 0 and "Iteration 0: 20 runs wait to be made by hand." in called.out and f"graincal tell {tmp_path / 'campaign'} FOLDER" in called.out
    return tmp_path / "campaign"


def test_it_finds_bit_for_bit_what_the_function_gives(call, tmp_path):
    for name, kind in {"function": FUNCTION, "hand": BY_HAND}.items():
        (tmp_path / name).mkdir()
        assert call("calibrate", write_calibration(tmp_path / name, TWO, (FUNCTION, kind)), "-o", tmp_path / name / "campaign").code == 0
    assert by_hand(call, tmp_path / "hand" / "campaign", tmp_path) == 2
    one, other = (gc.Result.read(tmp_path / name / "campaign") for name in ("function", "hand"))
    assert_same(one, other)
    assert one.failures == other.failures > 0 and one.stopped_because == other.stopped_because
    assert (
        "runs made by hand" in (tmp_path / "hand" / "campaign" / "report.html").read_text(encoding="utf-8")
        and (tmp_path / "hand" / "campaign" / "curves" / "drained_best.csv").exists()
    )


@pytest.mark.usefixtures("fewer_draws")
@pytest.mark.parametrize("ahead", [0, 1])
def test_the_runs_at_the_answer_are_asked_for_too(call, tmp_path, ahead):
    """So are batches that are asked for ahead of the one that is told."""
    for name, kind in {"function": FUNCTION, "hand": BY_HAND}.items():
        (tmp_path / name).mkdir()
        posterior = (POSTERIOR[0], f"{POSTERIOR[1]}\nahead = {ahead}")
        assert (
            call("calibrate", write_calibration(tmp_path / name, TWO, posterior, NO_CRITERIA, (FUNCTION, kind)), "-o", tmp_path / name / "campaign").code == 0
        )
    assert by_hand(call, tmp_path / "hand" / "campaign", tmp_path) == 3 - ahead
    one, other = (gc.Result.read(tmp_path / name / "campaign") for name in ("function", "hand"))
    assert_same(one, other)
    np.testing.assert_array_equal(one.answer.theta, other.answer.theta)
    np.testing.assert_array_equal(one.posterior.samples, other.posterior.samples)
    assert len(other.answer.errors) == 3


def test_the_same_is_asked_for_until_it_is_told(call, begun, tmp_path):
    asked = call("ask", begun).out
    assert call("resume", begun).code == 0 and call("ask", begun).out == asked
    runs = make(asked, tmp_path / "runs")
    few = tmp_path / "few"
    few.mkdir()
    for name in ("7.csv", "3.csv", "12.csv"):
        shutil.move(runs / name, few / name)
    told = call("tell", begun, few)
    assert told.code == 0 and told.out == "3 outcomes kept; 17 runs still to be made.\n"
    rest = call("ask", begun).out.splitlines()
    assert rest == [line for line in asked.splitlines() if line.partition(",")[0] not in ("3", "7", "12")]
    found = status(begun)
    assert found["state"] == "waiting" and found["by_hand"] == 17 and "17 runs wait to be made by hand" in call("status", begun).out
    assert "Iteration 1: 20 runs wait" in call("tell", begun, runs).out


def test_a_file_that_was_told_before_changes_nothing_and_another_one_is_refused(call, begun, tmp_path):
    runs = make(call("ask", begun).out, tmp_path / "runs")
    for path in [*runs.iterdir()]:
        if path.stem != "4":
            path.unlink()
    (runs / "1.failed").write_text("it jams")
    assert call("tell", begun, runs).code == 0
    before = [Store.open(begun).outcome(id, 0) for id in (1, 4)]
    again = call("tell", begun, runs)
    assert again.code == 0 and again.out == "0 outcomes kept, 2 told before; 18 runs still to be made.\n"
    write_curve(runs / "4.csv", respond(np.array([0.1, 0.1])))
    (runs / "1.failed").write_text("another reason")
    other = call("tell", begun, runs)
    assert other.code == 1 and other.err.count("something else was told of sample") == 2 and "2 files could not be taken" in other.err
    for told, kept in zip(before, (Store.open(begun).outcome(id, 0) for id in (1, 4))):
        assert repr(told) == repr(kept)


def test_what_cannot_be_taken_is_said_and_the_rest_is_kept(call, begun, tmp_path):
    runs = tmp_path / "runs"
    runs.mkdir()
    good = respond(np.array([0.5, 0.5]))
    write_curve(runs / "0.csv", good)
    write_curve(runs / "1.csv", {"stress_ratio": good["stress_ratio"]})
    write_curve(runs / "2.csv", {name: values[:5] for name, values in good.items()}, STRAIN[:5])
    write_curve(runs / "3.csv", good | {"stress_ratio": np.where(STRAIN > 0.1, np.nan, good["stress_ratio"])})
    write_curve(runs / "99.csv", good)
    write_curve(runs / "run 5.csv", good)
    write_curve(runs / "6.csv", good)
    (runs / "6.failed").write_text("no")
    (runs / "7.failed").write_text("infeasible: the packing jams")
    (runs / "8.failed").touch()
    (runs / "9.csv").touch()
    (runs / "notes.txt").write_text("of no interest")
    told = call("tell", begun, runs)
    assert told.code == 1 and "5 outcomes kept, 5 refused; 15 runs still to be made." in told.out
    assert "2.csv: kept as a failure (incomplete)" in told.out and "3.csv: kept as a failure (not_finite)" in told.out
    for sentence in ("1.csv: ", "99.csv: there is no sample 99", "run 5.csv: the id of a sample was expected", "6.csv: ", "9.csv: "):
        assert sentence in told.err, sentence
    assert "1.csv: 1.csv: " not in told.err
    assert "volumetric_strain" in told.err and "notes" not in told.err
    outcomes = Store.open(begun).outcomes(range(10), 0)
    assert [type(each).__name__ for each in outcomes] == ["Response", "NoneType", "Failure", "Failure", *["NoneType"] * 3, "Failure", "Failure", "NoneType"]
    assert [outcomes[id].kind for id in (7, 8)] == ["infeasible", "failed"] and outcomes[7].reason == "the packing jams"


def test_a_folder_without_a_run_is_said(call, begun, tmp_path):
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "notes.txt").write_text("of no interest")
    told = call("tell", begun, tmp_path / "runs")
    assert told.code == 0 and "no file <id>.csv or <id>.failed was found in it." in told.out


def test_a_campaign_that_a_process_runs_is_left_alone(call, begun, tmp_path):
    log = Log(begun)
    try:
        for arguments in (["ask", begun], ["tell", begun, tmp_path]):
            called = call(*arguments)
            assert called.code == 1 and "process is running this campaign" in called.err
    finally:
        log.close()
    assert "a folder with files" in call("tell", begun, tmp_path / "nowhere").err


def test_any_kind_can_be_asked_and_told(call, tmp_path):
    """A campaign of a function is broken off, told the rest of a batch and one more by hand, and ended by the function."""
    file = write_calibration(tmp_path)
    assert call("calibrate", file, "-o", tmp_path / "whole").code == 0
    with broken_off(7):
        gc.campaign.begin(gc.campaign.file.config.read_calibration(file), tmp_path / "campaign")
    for turn in range(2):
        asked = call("ask", tmp_path / "campaign").out
        assert len(asked.splitlines()) == 1 + (13, 20)[turn]
        told = call("tell", tmp_path / "campaign", make(asked, tmp_path / f"runs {turn}"))
        assert told.code == 0 and f"Iteration {turn + 1}: 20 runs wait" in told.out
    assert call("resume", tmp_path / "campaign").code == 0
    one, other = (gc.Result.read(tmp_path / name) for name in ("whole", "campaign"))
    np.testing.assert_array_equal(one.errors, other.errors)
    np.testing.assert_array_equal(one.samples, other.samples)


def test_a_model_that_was_handed_over_in_python_is_not_needed(call, tmp_path):
    options = {"method": "iterative-bayesian", "stop": gc.Stop(max_iterations=1), "folder": tmp_path / "campaign"}
    with broken_off(3):
        gc.calibrate(gc.PythonModel(respond), reference(), SPACE, **options)
    assert by_hand(call, tmp_path / "campaign", tmp_path) == 1
    assert gc.Result.read(tmp_path / "campaign").stopped_by == "max_iterations"


def of_two(kinds, tmp_path):
    text = write_calibration(tmp_path, TWO).read_text()
    head, _, rest = text.partition("[[experiment]]")
    table, _, tail = rest.partition("[filter]")
    tables = [table.replace('"drained"', f'"{name}"').replace(FUNCTION, kind) for name, kind in zip(("at 1 bar", "at 2 bar"), kinds)]
    (tmp_path / "calibration.toml").write_text(
        head.replace("unit =", "per_experiment = true, unit =") + "".join(f"[[experiment]]{each}" for each in tables) + f"[filter]{tail}"
    )
    return tmp_path / "calibration.toml"


def test_several_experiments_are_told_in_folders_of_their_names(call, tmp_path):
    assert "(at_1_bar, at_2_bar)" in call("calibrate", of_two([BY_HAND, BY_HAND], tmp_path), "-o", tmp_path / "campaign").out
    both = [*csv.DictReader(io.StringIO(call("ask", tmp_path / "campaign").out))]
    assert list(both[0]) == ["id", "experiment", *SPACE.names]
    first, second = (call("ask", tmp_path / "campaign", "--experiment", name).out for name in ("at 1 bar", "at 2 bar"))
    assert len(both) == len(first.splitlines()) + len(second.splitlines()) - 2
    (tmp_path / "strange" / "1 bar").mkdir(parents=True)
    (tmp_path / "strange" / "1 bar" / "0.csv").touch()
    strange = call("tell", tmp_path / "campaign", tmp_path / "strange")
    assert strange.code == 1 and "1 bar: there is no experiment of this name, and one of at_1_bar, at_2_bar was expected." in strange.err
    # One is named as the experiment is, the other as its files are.
    for name, asked in {"at 1 bar": first, "at_2_bar": second}.items():
        (tmp_path / "told").mkdir(exist_ok=True)
        make(asked, tmp_path / "told" / name)
    told = call("tell", tmp_path / "campaign", tmp_path / "told")
    assert told.code == 0 and "Iteration 1:" in told.out
    # Samples that failed in the first are not needed in the second, and are said if they are told.
    assert "not needed, for sample" in told.out
    write_curve(tmp_path / "told" / "20.csv", respond(np.array([0.5, 0.5])))
    assert "one of at_1_bar, at_2_bar was expected" in call("tell", tmp_path / "campaign", tmp_path / "told").err
    (tmp_path / "told" / "20.csv").unlink()
    (tmp_path / "told" / "notes").mkdir()
    write_curve(tmp_path / "told" / "notes" / "made on Monday.csv", respond(np.array([0.5, 0.5])))
    assert not call("tell", tmp_path / "campaign", tmp_path / "told").err
    shutil.copytree(tmp_path / "told" / "at 1 bar", tmp_path / "told" / "at 1 bsr")
    assert "at 1 bsr: there is no experiment of this name" in call("tell", tmp_path / "campaign", tmp_path / "told").err
    assert 'there is no experiment "at 3 bar" (did you mean' in call("ask", tmp_path / "campaign", "--experiment", "at 3 bar").err


@pytest.mark.parametrize("kinds", [[BY_HAND, FUNCTION], [FUNCTION, BY_HAND]])
def test_what_graincal_runs_itself_does_not_wait_for_the_hand(call, tmp_path, kinds):
    name = ("at 1 bar", "at 2 bar")[kinds.index(BY_HAND)]
    (tmp_path / "alone").mkdir()
    assert call("calibrate", of_two([FUNCTION, FUNCTION], tmp_path / "alone"), "-o", tmp_path / "alone" / "campaign").code == 0
    assert call("calibrate", of_two(kinds, tmp_path), "-o", tmp_path / "campaign").code == 0
    store = Store.open(tmp_path / "campaign")
    assert all(outcome is not None for outcome in store.outcomes(range(len(store.samples(0))), 1 - kinds.index(BY_HAND)))
    for turn in range(2):
        asked = call("ask", tmp_path / "campaign").out
        (tmp_path / f"told {turn}").mkdir()
        make(asked, tmp_path / f"told {turn}" / name)
        assert call("tell", tmp_path / "campaign", tmp_path / f"told {turn}").code == 0
    one, other = (gc.Result.read(folder / "campaign") for folder in (tmp_path / "alone", tmp_path))
    np.testing.assert_array_equal(one.samples, other.samples)
    np.testing.assert_array_equal(one.errors, other.errors)


def test_derived_parameters_are_printed_and_columns_are_read_as_they_are_declared(call, tmp_path):
    columns = 'columns = { axial_strain = "eps [%]", stress_ratio = "s1 / s3", volumetric_strain = { column = "ev", unit = "%", sign = -1 } }'
    model = f'kind = "by-hand", derived = {{ E = "10**(7 + strength)", double = "2 * E" }}, output = {{ file = "curve.txt", {columns} }}'
    assert "<id>.txt" in call("calibrate", write_calibration(tmp_path, TWO, (FUNCTION, model)), "-o", tmp_path / "campaign").out
    asked = [*csv.DictReader(io.StringIO(call("ask", tmp_path / "campaign").out))]
    assert list(asked[0]) == ["id", *SPACE.names, "E", "double"]
    theta = np.array([float(asked[4][name]) for name in SPACE.names])
    assert float(asked[4]["E"]) == 10 ** (7 + theta[0]) and float(asked[4]["double"]) == 2 * float(asked[4]["E"])
    np.testing.assert_array_equal(theta, Store.open(tmp_path / "campaign").samples(0).theta[4])
    curve, runs = respond(theta), tmp_path / "runs"
    runs.mkdir()
    table = np.stack([100 * STRAIN, 2 * curve["stress_ratio"], np.full(len(STRAIN), 2.0), -100 * curve["volumetric_strain"]], axis=1)
    np.savetxt(runs / "4.txt", table, header="eps s1 s3 ev", fmt="%.17g")
    assert call("tell", tmp_path / "campaign", runs).code == 0
    told = Store.open(tmp_path / "campaign").outcome(4, 0)
    for name in ("stress_ratio", "volumetric_strain"):
        np.testing.assert_allclose(told.values[name], curve[name], rtol=1e-14, atol=1e-16)


@pytest.mark.parametrize(
    "model, said",
    [
        ('kind = "by-hand", derived = { E = "10**log_E" }', 'derived.E is "10**log_E", which needs log_E'),
        ('kind = "by-hand", derived = { E = "open(1)" }', "there is no function open"),
        ('kind = "by-hand", derived = { strength = "1" }', "derived.strength is the name of a parameter too"),
        ('kind = "by-hand", output = { columns = { stress_ratio = "q" } }', "output.columns has no axial_strain"),
        ('kind = "by-hand", output = { columns = { axial_strain = "e", stress_ratio = "q" } }', "volumetric_strain is not an observable of the model"),
    ],
)
def test_what_cannot_be_is_said_before_anything_is_asked(call, tmp_path, model, said):
    called = call("calibrate", write_calibration(tmp_path, (FUNCTION, model)), "-o", tmp_path / "campaign")
    assert called.code == 1 and said in called.err and called.err.startswith(str(tmp_path / "calibration.toml"))


def test_a_store_keeps_how_curves_are_read(tmp_path):
    output = Output(
        {"axial_strain": Column("e", "%"), "stress_ratio": Column("q"), "volumetric_strain": Column(3, sign=-1)},
        "c.csv",
        ("axial_strain",),
        2,
        "stage == 2",
        "engineering",
    )
    with pytest.raises(RunsWait, match="runs wait to be made by hand"):
        gc.calibrate(ByHandModel(output, {"E": "10**strength"}), reference(), SPACE, folder=tmp_path / "campaign")
    kept = Store.open(tmp_path / "campaign").calibration.experiments[0].model
    assert kept.output == output and kept.derived == {"E": "10**strength"}
    with pytest.raises(gc.InputError, match="folder = a folder of its own"):
        gc.calibrate(ByHandModel(), reference(), SPACE)


def test_yade_reads_its_table(call, begun, tmp_path):
    table = call("ask", begun, "--format", "yade").out
    lines = table.splitlines()
    assert lines[0] == "description strength dilatancy" and [line.split()[0] for line in lines[1:]] == [str(id) for id in range(20)]
    samples = Store.open(begun).samples(0)
    np.testing.assert_array_equal([[float(cell) for cell in line.split()[1:]] for line in lines[1:]], samples.theta)
    (asked,) = ask(begun)
    with pytest.raises(gc.InputError, match="--format csv takes it"):
        as_yade_table(type(asked)("x", asked.ids, ("two words", "b"), asked.values))
    if not shutil.which("yade"):
        pytest.skip("there is no yade to read the table")
    (tmp_path / "samples.txt").write_text(table)
    script = tmp_path / "read.py"
    script.write_text(
        "from yade import utils\nutils.readParamsFromTable(tableFileLine='samples.txt:6', strength=0., dilatancy=0.)\nfrom yade.params import table\n"
        "import json\nopen('read.json', 'w').write(json.dumps([O.tags['description'], table.strength, table.dilatancy]))\n"
    )
    subprocess.run(["yade", "-n", "-x", "-j", "1", script.name], cwd=tmp_path, check=True, capture_output=True, timeout=120)
    description, *theta = json.loads((tmp_path / "read.json").read_text())
    np.testing.assert_array_equal(theta, samples.theta[int(description)])


def test_a_library_is_filled_by_hand_too(call, tmp_path):
    file = write_calibration(tmp_path, POSTERIOR, NO_CRITERIA, (FUNCTION, BY_HAND))
    called = call("explore", file, "-o", tmp_path / "library", "--runs", "6")
    assert called.code == 0 and "6 runs wait to be made by hand." in called.out
    runs = make(call("ask", tmp_path / "library").out, tmp_path / "runs")
    told = call("tell", tmp_path / "library", runs)
    assert told.code == 0 and "All 6 runs have been made" in told.out
    learnt = call("calibrate", file, "-o", tmp_path / "campaign", "--runs", tmp_path / "library")
    assert learnt.code == 0 and "Learns from 6 runs" in learnt.out


def test_whoever_tells_from_python_hears_what_became_of_it(begun, tmp_path):
    (tmp_path / "runs").mkdir()
    write_curve(tmp_path / "runs" / "0.csv", respond(np.array([0.5, 0.5])))
    told = tell(begun, tmp_path / "runs")
    assert (told.kept, told.known, told.left, told.whole, told.refused) == (1, 0, 19, False, [])


def test_a_built_in_test_can_be_told_by_hand_beside_its_own_runs(call, tmp_path):
    """A person's curves are on other rows than the engine's own states, and hold other quantities."""
    strain = np.linspace(0, 0.03, 16)
    run = gc.TriaxialTest(demo.packing(), 0.5e6, inertial_number=1e-2)
    options = {"method": "iterative-bayesian", "stop": gc.Stop(max_iterations=1), "alpha": 3, "folder": tmp_path / "campaign"}
    space = gc.ParameterSpace({"log_E": (8, 9), "phi": (20, 40)})
    test = gc.TriaxialTest(demo.packing(), 0.5e6, inertial_number=1e-2, fixed={"nu": 0.2, "beta_m": 0.1, "eta_m": 0.1})
    truth = run.simulate([[8.5, 0.2, 30, 0.1, 0.1]], at=strain)[0]
    measured = gc.Reference(
        strain, dict(zip(("stress_ratio", "volumetric_strain"), interpolate(truth, strain).observables(("stress_ratio", "volumetric_strain")).T))
    )
    with broken_off(2):
        gc.calibrate(test, measured, space, **options)
    runs = tmp_path / "runs"
    runs.mkdir()
    for line in call("ask", tmp_path / "campaign").out.splitlines()[1:]:
        write_curve(runs / f"{line.partition(',')[0]}.csv", dict(measured.observables), strain)
    assert call("tell", tmp_path / "campaign", runs).code == 0
    result = gc.Result.read(tmp_path / "campaign")
    curves = result.responses(0)["stress_ratio"]
    # The engine goes on to the first state of its own behind the reference, to which a person's curves do not come.
    assert (
        np.isfinite(curves[:, :-1]).all()
        and np.isfinite(curves[:, -1]).sum() == 2
        and result.best.error < 1e-9
        and (tmp_path / "campaign" / "report.html").exists()
    )


def test_packings_are_studied_by_graincal_alone(call, tmp_path):
    measured = gc.Reference(STRAIN[:4], {name: values[:4] for name, values in reference().observables.items()})
    test = gc.TriaxialTest(demo.packing(), 0.5e6, fixed={"nu": 0.2, "beta_m": 0.1, "eta_m": 0.1})
    with broken_off(0):
        gc.calibrate(test, measured, gc.ParameterSpace({"log_E": (8, 9), "phi": (20, 40)}), folder=tmp_path / "campaign", first_batch=8)
    runs = tmp_path / "runs"
    runs.mkdir()
    for line in call("ask", tmp_path / "campaign").out.splitlines()[1:]:
        write_curve(runs / f"{line.partition(',')[0]}.csv", dict(measured.observables), STRAIN[:4])
    told = call("tell", tmp_path / "campaign", runs)
    assert told.code == 1 and "8 outcomes kept" in told.out and "cannot be made by hand; graincal makes them by: graincal resume" in told.err
