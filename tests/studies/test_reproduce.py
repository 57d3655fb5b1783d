"""graincal reproduce: a study whole, at a toy size, and what stops it."""

import csv
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.found.run_library import Library
from graincal.campaign.stored.database import NAME as DATABASE
from graincal.campaign.stored.store import Store
from graincal.dem.preparation import prepare
from graincal.studies import paper
from graincal.studies.hartmann2022 import STUDIES
from graincal.studies.made_with import alone_in
from graincal.studies.proof import Proof
from graincal.studies.running import Reproduction
from graincal.studies.settings import QUICK, VOID_RATIO, Setup
from graincal.studies.study import Done
from graincal.studies.work import Running

GRAINCAL = Path(sys.executable).with_name("graincal")
STUDY = "errors"
PIECES = "runs-at-truth", "synthetic-mid-alpha-10-seed-1"


@pytest.fixture(scope="session")
def data(tmp_path_factory):
    """A folder with a synthetic reference alone, made by the engine: packings are the rehearsal's own."""
    folder = tmp_path_factory.mktemp("data")
    test = gc.TriaxialTest(prepare(QUICK.particles, VOID_RATIO, seed=3), 0.5e6, density_scaling=paper.DENSITY_SCALING)
    strains = np.linspace(0, 0.2, 26)
    (run,) = test.simulate([paper.TRUTH], at=strains)
    rows = np.column_stack([100 * strains, 100 * run.values["volumetric_strain"], run.values["stress_ratio"]])
    np.savetxt(folder / "synthetic_reference.csv", rows, delimiter=",", header="axial_strain [%],volumetric_strain [%],stress_ratio [-]", comments="")
    return folder


def arguments(data, folder, *more):
    return ["reproduce", "hartmann2022", "--study", STUDY, "--data", str(data), "--quick", "--seeds", "1", "-o", str(folder), *more]


@pytest.fixture(scope="session")
def made(data, tmp_path_factory):
    """The study, run to its end: its folder, and what the command printed."""
    folder = tmp_path_factory.mktemp("made") / "study"
    ended = subprocess.run([GRAINCAL, *arguments(data, folder)], capture_output=True, text=True, timeout=600)
    assert ended.returncode == 0, ended.stderr
    return folder, ended.stdout


def tables(folder):
    return {path.name: path.read_bytes() for path in (folder / "tables").iterdir()}


def test_a_study_ends_in_a_page_tables_and_figures(made):
    folder, printed = made
    assert f"{STUDY}: 2 of 2 to run" in printed and f"Written: {folder / 'index.html'}" in printed
    with (folder / "tables" / f"{STUDY}.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["setting", "quantity", "paper", "graincal median", "low", "high", "floor"]
    first = next(row for row in rows if (row["setting"], row["quantity"]) == ("iteration 0", "ε [%]"))
    assert first["paper"] == "16.46" and float(first["low"]) == float(first["graincal median"]) == float(first["high"]) > 0 and float(first["floor"]) > 0
    # The paper has iterations that a rehearsal does not come to.
    last = next(row for row in rows if row["setting"] == "iteration 10" and row["quantity"] == "ε [%]")
    assert (last["paper"], last["graincal median"]) == ("1.13", "")
    assert (folder / "figures" / "figure-18.png").read_bytes().startswith(b"\x89PNG")
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert 'accuracy is "standard"' in re.sub(r"&quot;|&#34;", '"', page)
    assert "rehearsal" in page and "cannot be told" in page and "16.46" in page and "does not hold" not in page


def test_its_numbers_are_those_of_its_calibration(made):
    folder, _ = made
    result = gc.Result.read(folder / "work" / PIECES[1])
    best = result.iterations[0].most_probable
    with (folder / "tables" / f"{STUDY}.csv").open(encoding="utf-8", newline="") as file:
        found = {row["quantity"]: row["graincal median"] for row in csv.DictReader(file) if row["setting"] == "iteration 0"}
    (row,) = np.flatnonzero(result.ids == result.iterations[0].samples.ids[best])
    assert float(found["ε [%]"]) == pytest.approx(result.errors[row], rel=1e-5)
    assert float(found["ε stress ratio [%]"]) == pytest.approx(result.observable_errors[row, 0], rel=1e-5)


def test_again_nothing_is_run_and_the_tables_are_the_same(made, data, call):
    folder, _ = made
    before = tables(folder)
    ended = call(*arguments(data, folder))
    assert ended.code == 0 and f"{STUDY}: all 2 run" in ended.out
    assert tables(folder) == before


def evaluated(folder, piece):
    """How many runs of a piece of work are stored."""
    try:
        with sqlite3.connect(f"file:{folder / 'work' / piece / DATABASE}?mode=ro", uri=True) as database:
            return database.execute("SELECT count(*) FROM evaluation WHERE state != 'waiting'").fetchone()[0]
    except sqlite3.OperationalError:
        return 0


@pytest.mark.parametrize("stop", [signal.SIGKILL, signal.SIGINT])
def test_a_study_that_is_stopped_goes_on_to_the_same_tables(made, data, tmp_path, stop, call):
    folder = tmp_path / "study"
    process = subprocess.Popen([GRAINCAL, *arguments(data, folder)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for _ in range(6000):
        if evaluated(folder, PIECES[1]) >= 20 or process.poll() is not None:
            break
        time.sleep(0.02)
    os.kill(process.pid, stop)
    _, said = process.communicate(timeout=120)
    assert process.returncode == (-9 if stop == signal.SIGKILL else 130)
    assert stop == signal.SIGKILL or "the same command goes on with it" in said
    assert not (folder / "index.html").exists()
    kept = evaluated(folder, PIECES[1])
    ended = call(*arguments(data, folder))
    assert kept >= 20 and f"{STUDY}: 1 of 2 to run" in ended.out
    assert tables(folder) == tables(made[0])


def test_what_lacks_a_file_is_skipped_beside_the_papers_numbers(tmp_path, call):
    (tmp_path / "nothing").mkdir()
    ended = call(*arguments(tmp_path / "nothing", tmp_path / "study", "--study", "pressures", "--study", "monte-carlo"))
    assert ended.code == 0
    assert "monte-carlo: skipped, for toyoura_0.2MPa.csv is not in the data folder: 0.2 MPa, GL" in ended.out.replace("\n", " ")
    assert "another one is named by --data." in ended.out.replace("\n", " ")
    page = (tmp_path / "study" / "index.html").read_text(encoding="utf-8")
    assert "graincal: skipped" in page and "synthetic_reference.csv is not in" in page and "21.41" in page
    assert {path.name for path in (tmp_path / "study" / "tables").iterdir()} >= {"table-03.csv", f"{STUDY}.csv", "table-10.csv"}


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (["reproduce", "hartman2022", "-o", "x"], 'did you mean "hartmann2022"'),
        (["reproduce", "hartmann2022", "--study", "error", "-o", "x"], 'did you mean "errors"'),
        (["reproduce", "hartmann2022", "--data", "nowhere", "-o", "x"], "--data nowhere: there is no such folder"),
    ],
)
def test_what_it_does_not_know_is_said(wrong, said, call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ended = call(*wrong)
    assert ended.code == 1 and said in ended.err.replace("\n", " ") and not (tmp_path / "x").exists()


def test_work_of_other_data_or_another_size_is_refused(made, data, tmp_path, call):
    """What is there never passes for what is asked for: nothing is mixed, and nothing overwritten."""
    folder, _ = made
    before, page = tables(folder), (folder / "index.html").read_bytes()
    lines = (data / "synthetic_reference.csv").read_text().splitlines()
    (tmp_path / "synthetic_reference.csv").write_text("\n".join(lines[:-2]) + "\n")
    other = call(*arguments(tmp_path, folder))
    assert other.code == 1 and "was made with another file of this name" in other.err.replace("\n", " ") and "synthetic_reference.csv" in other.err
    larger = call(*(each for each in arguments(data, folder) if each != "--quick"))
    assert larger.code == 1 and "was made with --quick" in larger.err.replace("\n", " ")
    assert tables(folder) == before and (folder / "index.html").read_bytes() == page


def test_files_may_be_added(made, data, tmp_path, call):
    folder, _ = made
    shutil.copytree(folder, tmp_path / "study")
    shutil.copytree(data, tmp_path / "data")
    (tmp_path / "data" / "toyoura_0.2MPa.csv").write_text("axial_strain [%],stress_ratio [-]\n0,1\n")
    assert call(*arguments(tmp_path / "data", tmp_path / "study")).code == 0


SMALLEST = replace(QUICK, of_samples=0.1, most_iterations=2, most_evaluations=23, repeats=2)


def reproduced(data, folder, *names):
    """Studies in a folder, as small as they can be: what was said."""
    said = []
    reproduction = Reproduction([STUDIES[name] for name in names], Setup(data, 1, size=SMALLEST), folder, "Studies", said.append)
    reproduction.run()
    assert not reproduction.broken
    return said


FOLLOWING = "stress-only", "pressures"


@pytest.fixture(scope="session")
def alone(data, tmp_path_factory):
    """Two studies, run to their end: calibrations that learn from others, and runs at what others found."""
    folder = tmp_path_factory.mktemp("alone") / "study"
    reproduced(data, folder, *FOLLOWING)
    return folder


def test_what_follows_from_other_work_is_run_after_it(alone):
    """The calibration with stress only learns from the runs of the other one, and runs are made at what both found."""
    with closing(Store.open(alone / "work" / "synthetic-mid-posterior-stress-only-seed-1")) as store:
        assert "synthetic-mid-posterior-seed-1" in store.description["known"]["sources"][0]
    calibrated = gc.Result.read(alone / "work" / PIECES[1])
    own = Library.read(alone / "work" / "runs-at-own-0.2MPa-1")
    np.testing.assert_allclose(own.samples.theta[0], calibrated.most_probable.theta, rtol=1e-5)
    assert len(Library.read(alone / "work" / "runs-at-draws-stress-only").samples) == 30
    with (alone / "tables" / "table-10.csv").open(encoding="utf-8", newline="") as file:
        settings = {row["setting"] for row in csv.DictReader(file) if row["graincal median"]}
    assert settings >= {"0.2 MPa, our parameters", "0.2 MPa, our parameters, posterior"}


def test_work_in_another_place_is_gone_on_with(alone, data, tmp_path):
    """Of runs that a calibration learnt from it counts what they are, and not where they were: also of one that is not at its end."""
    shutil.copytree(alone, tmp_path / "study")
    piece = tmp_path / "study" / "work" / "synthetic-mid-posterior-stress-only-seed-1"
    with closing(Store.open(piece)) as store:
        store.database.rows("DELETE FROM meta WHERE key IN ('stopped_by', 'stopped_because')")
    said = " ".join(reproduced(data, tmp_path / "study", *FOLLOWING))
    assert "could not be run" not in said and "stress-only: 1 of" in said
    assert tables(tmp_path / "study") == tables(alone)


def test_work_at_its_end_of_other_settings_is_left_out_and_said(alone, data, tmp_path):
    """And so is what follows from it. Nothing is overwritten."""
    shutil.copytree(alone, tmp_path / "study")
    work = tmp_path / "study" / "work"
    with closing(Store.open(work / "synthetic-mid-posterior-seed-1")) as store:
        store.database.rows("UPDATE meta SET value = json_set(value, '$.commit', 'another') WHERE key = 'provenance'")
        store.database.rows("UPDATE meta SET value = json_set(value, '$.seed', 17) WHERE key = 'description'")
    before = {path: path.read_bytes() for path in work.glob(f"*/{DATABASE}")}
    said = " ".join(reproduced(data, tmp_path / "study", *FOLLOWING))
    assert "this was made by other settings" in said and "what it follows from is left out" in said
    page = (tmp_path / "study" / "index.html").read_text(encoding="utf-8")
    assert "this was made by other settings" in page and "1 of " in page
    assert {path: path.read_bytes() for path in work.glob(f"*/{DATABASE}")} == before


def test_two_commands_in_one_folder_are_refused(made, data, call):
    folder, _ = made
    before = tables(folder)
    with alone_in(folder / "work"):
        ended = call(*arguments(data, folder))
    assert ended.code == 1 and "another process is running studies in this folder" in ended.err.replace("\n", " ")
    assert tables(folder) == before and call(*arguments(data, folder)).code == 0


def test_what_a_folder_was_made_with_is_read_or_refused(made, data, tmp_path, call):
    folder, _ = made
    shutil.copytree(folder, tmp_path / "study")
    kept = tmp_path / "study" / "work" / "made-with.json"
    kept.write_text(kept.read_text()[:20])
    ended = call(*arguments(data, tmp_path / "study"))
    assert ended.code == 1 and "cannot be understood" in ended.err.replace("\n", " ")
    kept.unlink()
    assert call(*arguments(data, tmp_path / "study")).code == 0 and kept.read_text() == (folder / "work" / "made-with.json").read_text()


def without_weights(folder):
    """Take the weights of all iterations from a calibration."""
    with closing(Store.open(folder)) as store:
        store.database.rows("UPDATE iteration SET unweighted = 'none', s = NULL, effective_sample_size = NULL, gl_error = NULL")


def test_a_calibration_without_weights_stops_no_study(alone, data, tmp_path):
    """All that follows from it is said not to be known, of all studies that use it."""
    shutil.copytree(alone, tmp_path / "study")
    work = tmp_path / "study" / "work"
    without_weights(work / PIECES[1])
    for name in ("runs-at-own-0.2MPa-1", "runs-at-own-1MPa-1"):
        shutil.rmtree(work / name)
    assert "what they follow from found none" in " ".join(reproduced(data, tmp_path / "study", *FOLLOWING))
    page = (tmp_path / "study" / "index.html").read_text(encoding="utf-8")
    assert "what they follow from found none" in page and "could not be evaluated" not in page


def test_iterations_without_weights_leave_the_others_in_their_rows(made, data, tmp_path, call):
    folder, _ = made
    shutil.copytree(folder, tmp_path / "study")
    with closing(Store.open(tmp_path / "study" / "work" / PIECES[1])) as store:
        store.database.rows("UPDATE iteration SET unweighted = 'none', s = NULL, effective_sample_size = NULL, gl_error = NULL WHERE id = 1")
    assert call(*arguments(data, tmp_path / "study")).code == 0
    read = [list(csv.DictReader((each / "tables" / f"{STUDY}.csv").open(encoding="utf-8", newline=""))) for each in (folder, tmp_path / "study")]
    of = [{(row["setting"], row["quantity"]): row["graincal median"] for row in rows} for rows in read]
    assert of[1] == {key: "" if key[0] == "iteration 1" else value for key, value in of[0].items()}


def test_a_mistake_in_one_study_costs_the_others_no_page(made, data, tmp_path, call, monkeypatch):
    def broken(*arguments):
        raise ZeroDivisionError("nothing to divide by")

    folder, _ = made
    shutil.copytree(folder, tmp_path / "study")
    monkeypatch.setattr(Proof, "findings", broken)
    reproduction = Reproduction([STUDIES[STUDY], STUDIES["proof"]], Setup(data, 1, size=QUICK), tmp_path / "study", "Studies")
    reproduction.write()
    page = (tmp_path / "study" / "index.html").read_text(encoding="utf-8")
    assert list(reproduction.broken) == ["proof"] and "ZeroDivisionError: nothing to divide by" in page and "16.46" in page


def test_as_many_run_at_once_as_workers_are_asked_for(data, tmp_path):
    setup = Setup(data, workers=1, size=QUICK)
    for case in [case for study in STUDIES.values() for case in study.cases(setup, Done(tmp_path))]:
        assert all(work.workers == 1 for work in case.work if isinstance(work, Running))
