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
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal.campaign.store import NAME as DATABASE
from graincal.dem.preparation import prepare
from graincal.studies import paper
from graincal.studies.settings import QUICK, VOID_RATIO

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
