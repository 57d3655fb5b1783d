"""The store gives back, bit for bit, what it was given; and nothing is lost or overwritten when it cannot write."""

import shutil
import signal
import sqlite3
import zlib
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import graincal as gc
from graincal import Experiment, Failure, FolderError, InputError, PythonModel, Response, Stop, TriaxialTest
from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.description import AbsentModel, describe, restore
from graincal.campaign.found.status import status
from graincal.campaign.stored.database import columns_of
from graincal.campaign.stored.store import Store, holds_campaign

from .hyperbola import SPACE, STRAIN, TRUTH, model, reference, respond
from .test_calibration_file import write_triaxial


def calibration(**changes):
    options = {"filter_options": {"alpha": 10, "scale": "pointwise"}, "stop": Stop(s=False, max_iterations=2), "seed": 7, "workers": 1} | changes
    return Calibration(SPACE, [Experiment("drained", model(), reference())], **{"method": "iterative-bayesian"} | options)


@pytest.fixture(params=["folder", "memory"])
def store(request, tmp_path):
    return Store.create(calibration(), tmp_path if request.param == "folder" else None)


def asked(store):
    samples = store.calibration.new_filter().ask()
    store.ask(0, samples, experiments=1)
    return samples


def test_what_was_asked_comes_back_whole(store):
    back, given = store.calibration, calibration()
    np.testing.assert_array_equal([back.space.low, back.space.high], [given.space.low, given.space.high])
    np.testing.assert_array_equal(back.experiments[0].reference.values, given.experiments[0].reference.values)
    assert (back.method, back.filter_options, back.stop, back.seed, back.workers) == (given.method, given.filter_options, given.stop, 7, 1)
    assert store.keeps(given) and store.keeps(calibration(workers=2)) and not store.keeps(calibration(seed=8))


def test_a_known_truth_is_kept_and_changes_nothing_of_what_is_asked(tmp_path):
    given = calibration(truth={"strength": 0.6}).check()
    store = Store.create(given, tmp_path)
    assert store.calibration.truth == {"strength": 0.6} and store.keeps(calibration())


@pytest.mark.parametrize(
    ("truth", "said"), [({"phi": 30}, "truth.phi is not a parameter; expected some of strength"), ({"strength": np.nan}, "truth.strength must be a number")]
)
def test_a_truth_of_something_else_is_refused(truth, said):
    with pytest.raises(InputError, match=said):
        calibration(truth=truth).check()


def test_samples_and_outcomes_come_back_bit_for_bit(store):
    samples = asked(store)
    np.testing.assert_array_equal(store.samples(0).theta, samples.theta)
    assert list(store.waiting(0, 0)) == list(samples.ids)

    third = 1 / 3 * STRAIN
    store.record(samples.ids[0], 0, Response(STRAIN, {"stress_ratio": 1 + third, "φ": third}, {"seconds": 0.1, "steps": 12}))
    store.record(samples.ids[1], 0, Failure("diverged", "it ran away.", {"seconds": 2.5}))
    response, failure = store.outcome(samples.ids[0], 0), store.outcome(samples.ids[1], 0)
    np.testing.assert_array_equal(response.values["φ"], third)
    assert response.details == {"seconds": 0.1, "steps": 12}
    assert failure == Failure("diverged", "it ran away.", {"seconds": 2.5})
    assert store.outcome(samples.ids[2], 0) is None
    assert len(store.waiting(0, 0)) == len(samples) - 2
    assert store.counts() == {"samples": len(samples), "evaluated": 2, "failed": 1, "stopped": 0}


def test_other_samples_under_the_same_ids_are_refused(store):
    samples = asked(store)
    store.ask(0, samples, experiments=1)
    moved = samples.take(slice(None))
    object.__setattr__(moved, "theta", samples.theta + 1e-6)
    with pytest.raises(InputError, match="iteration 0 comes out with other samples than are stored"):
        store.ask(0, moved, experiments=1)


def test_an_iteration_comes_back_bit_for_bit(store):
    filter = store.calibration.new_filter()
    samples = asked(store)
    responses = np.array([np.stack([respond(theta)["stress_ratio"], theta[1] * STRAIN], axis=1) for theta in samples.theta * 0.7])
    filter.tell(samples, responses, failed=np.arange(len(samples)) == 3)
    store.complete(filter.iterations[0])
    store.complete(filter.iterations[0])
    (back,), given = store.iterations(), filter.iterations[0]
    for name in ("weights", "errors", "observable_errors", "failed"):
        np.testing.assert_array_equal(getattr(back, name), getattr(given, name))
    assert (back.s, back.effective_sample_size, back.gl_error, back.unweighted) == (given.s, given.effective_sample_size, given.gl_error, "")


def test_a_triaxial_test_needs_no_file_once_it_is_stored(tmp_path):
    from graincal.campaign.file.config import read_calibration

    calibration = read_calibration(write_triaxial(tmp_path))
    (experiment,) = Store.create(calibration).calibration.experiments
    assert isinstance(experiment.model, TriaxialTest)
    np.testing.assert_array_equal(experiment.model.packing.positions, calibration.experiments[0].model.packing.positions)
    assert experiment.model.fixed == calibration.experiments[0].model.fixed


def test_a_contact_law_and_a_precision_are_stored(tmp_path):
    from graincal.campaign.file.config import read_calibration

    plain = read_calibration(write_triaxial(tmp_path))
    for name, other in (("law", "hertz-mindlin"), ("precision", "float64")):
        chosen = read_calibration(write_triaxial(tmp_path, ("confining_pressure = 2e5,", f'confining_pressure = 2e5, {name} = "{other}",')))
        assert getattr(Store.create(chosen).calibration.experiments[0].model, name) == other
        assert getattr(restore(describe(plain)).experiments[0].model, name) != other and describe(chosen) != describe(plain)


def test_a_response_is_kept_on_the_states_of_its_model(tmp_path):
    from graincal.campaign.file.config import read_calibration

    calibration = read_calibration(write_triaxial(tmp_path))
    (tmp_path / "campaign").mkdir()
    store = Store.create(calibration, tmp_path / "campaign")
    samples = asked(store)
    test, states = calibration.experiments[0].model, np.array([0.0, 0.0005, 0.001])
    kept = test.response(states, {"stress_ratio": 1 + states, "mean_stress": 2e5 + states}, {"steps": 7})
    store.record(samples.ids[0], 0, kept)
    store.close()
    found = Store.open(tmp_path / "campaign").outcome(samples.ids[0], 0)
    np.testing.assert_array_equal(found.control, states)
    # It serves another confining pressure as it is.
    assert (found.control_name, found.confining_pressure, found.in_pascal) == ("axial_strain", 2e5, ("mean_stress",))
    np.testing.assert_allclose(found.at_pressure(4e5).values["mean_stress"], 2 * kept.values["mean_stress"], rtol=1e-15)


def test_a_function_comes_back_by_its_name_alone(tmp_path):
    named = Store.create(Calibration(SPACE, [Experiment("x", PythonModel("soil:respond", folder=tmp_path), reference())]))
    assert named.calibration.experiments[0].model.function == "soil:respond"
    absent = Store.create(calibration()).calibration
    assert isinstance(absent.experiments[0].model, AbsentModel)
    with pytest.raises(InputError, match=r'experiment "drained": its model \(.*respond\) was handed over in Python'):
        absent.check()


def test_a_full_disk_is_one_sentence_and_loses_nothing_that_was_stored(tmp_path):
    store = Store.create(calibration(), tmp_path)
    samples = asked(store)
    pages = store._rows("PRAGMA page_count")[0][0]
    store._rows(f"PRAGMA max_page_count = {pages + 2}")
    kept = 0
    with pytest.raises(FolderError, match=r"campaign.db: the disk is full; what was finished before is safe"):
        for kept, id in enumerate(samples.ids):
            store.record(id, 0, Response(STRAIN, {f"q{i}": STRAIN for i in range(20)}))
    store.close()
    again = Store.open(tmp_path)
    assert kept > 0 and again.counts()["evaluated"] == kept
    assert len(again.outcome(samples.ids[kept - 1], 0).values) == 20


def test_a_beginning_cut_short_leaves_no_campaign(tmp_path):
    (tmp_path / "campaign.db").touch()
    assert not holds_campaign(tmp_path)
    with pytest.raises(InputError, match="there is no campaign in this folder"):
        Store.open(tmp_path)
    Store.create(calibration(), tmp_path)
    assert holds_campaign(tmp_path)


def test_a_file_that_is_no_store_is_said(tmp_path):
    (tmp_path / "campaign.db").write_text("not a database " * 100)
    with pytest.raises(FolderError, match=r"campaign.db: this cannot be read \(file is not a database\), and the store of a campaign was expected here"):
        Store.open(tmp_path)


@pytest.mark.parametrize(
    ("format", "said"),
    [(99, r"reads formats up to 5: a later version of graincal was expected"), (3, r"reads the formats 4 and 5 alone: calibrate again, in another folder")],
)
def test_a_store_of_another_format_is_refused(tmp_path, format, said):
    Store.create(calibration(), tmp_path).close()
    with sqlite3.connect(tmp_path / "campaign.db") as db:
        db.execute(f"PRAGMA user_version = {format}")
    with pytest.raises(InputError, match=rf"this campaign was stored by graincal [\d.]+ in the format {format}, and graincal [\d.]+ {said}"):
        Store.open(tmp_path)


def test_a_store_of_the_format_before_is_brought_up(tmp_path):
    shutil.copy(Path(__file__).parents[1] / "data" / "begun" / "engine" / "campaign.db", tmp_path)
    store = Store.open(tmp_path)
    assert store.database.version == 5 and store.counts()["evaluated"] == 25
    assert isinstance(store.outcome(0, 0), Response)
    # Its rows are guarded from now on.
    store.database.rows("UPDATE evaluation SET crc = crc + 1 WHERE sample = 0")
    with pytest.raises(FolderError, match=r"campaign.db: this store of a campaign is damaged \(a row of evaluation is not what was written\)"):
        store.outcome(0, 0)


def test_ctrl_c_while_sqlite_calls_back_is_no_fault_of_the_store(tmp_path, monkeypatch):
    hears = [False]

    def checksum(*values):
        if hears[0]:
            hears[0] = False
            signal.raise_signal(signal.SIGINT)
        return zlib.crc32(repr(values).encode())

    monkeypatch.setattr("graincal.campaign.stored.database._checksum", checksum)
    store = Store.create(calibration(), tmp_path)
    asked(store)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        for use in (lambda: store.keep("a", "b"), lambda: store.samples(0)):
            hears[0] = True
            with pytest.raises(KeyboardInterrupt):
                use()
    finally:
        signal.signal(signal.SIGINT, before)
    # What was begun is whole.
    assert store.meta("a") == "b" and len(store.samples(0))


@pytest.mark.parametrize("table", ["meta", "sample", "evaluation", "iteration"])
def test_a_number_that_flipped_is_found(tmp_path, table):
    """One bit of one value, beneath SQLite's own pages: nothing else would notice it."""
    result = gc.calibrate(gc.PythonModel(respond), reference(), SPACE, method="iterative-bayesian", stop=Stop(max_iterations=1), folder=tmp_path)
    store = Store.open(tmp_path)
    column = {"meta": "value", "sample": "theta", "evaluation": "response", "iteration": "weights"}[table]
    ((value,),) = store._rows(f"SELECT {column} FROM {table} {'WHERE key = ' + repr('description') if table == 'meta' else ''} LIMIT 1")
    data = value if isinstance(value, bytes) else value.encode()
    store.close()
    content = (tmp_path / "campaign.db").read_bytes()
    at = content.rindex(data[-40:]) + 20
    (tmp_path / "campaign.db").write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
    with pytest.raises(FolderError, match=f"damaged .a row of {table}"):
        read = gc.Result.read(tmp_path)
        [read.response(int(id)) for id in result.ids]


def test_whatever_a_store_holds_is_a_sentence_or_a_result(tmp_path):
    """Values of other kinds in every column, with checksums that are right: written by something else."""
    gc.calibrate(gc.PythonModel(respond), reference(), SPACE, method="iterative-bayesian", stop=Stop(max_iterations=1), folder=tmp_path / "whole")
    for table in ("meta", "sample", "evaluation", "iteration"):
        for column in columns_of(table):
            for value in ("", "nonsense", "[1", b"\x93NUMPY\x03\x00", 7):
                folder = shutil.copytree(tmp_path / "whole", tmp_path / "other")
                with suppress(FolderError):
                    Store.open(folder)._rows(f"UPDATE {table} SET {column} = ?", value)
                try:
                    read = gc.Result.read(folder)
                    [read.response(int(id)) for id in read.ids]
                    status(folder)
                except InputError as error:
                    assert str(folder) in str(error) and "\n" not in str(error)
                shutil.rmtree(folder)


def test_details_that_are_not_finite_are_kept(store):
    samples = asked(store)
    store.record(samples.ids[0], 0, Failure("infeasible", "no.", {"reached": np.nan, "stopped": np.inf}))
    assert np.isnan(store.outcome(samples.ids[0], 0).details["reached"]) and store.counts()["failed"] == 1


def test_many_further_quantities_come_back(store):
    samples = asked(store)
    values = {f"displacement_of_gauge_{number:03d}_mm": STRAIN for number in range(600)}
    store.record(samples.ids[0], 0, Response(STRAIN, values))
    assert list(store.outcome(samples.ids[0], 0).values) == list(values)


def test_a_reader_sees_what_is_finished_while_the_writer_goes_on(tmp_path):
    writer = Store.create(calibration(), tmp_path)
    samples = asked(writer)
    reader = Store.open(tmp_path)
    for done, id in enumerate(samples.ids[:3]):
        assert reader.counts()["evaluated"] == done
        writer.record(id, 0, Failure("error", "no."))
    np.testing.assert_array_equal(reader.samples(0).theta @ TRUTH, samples.theta @ TRUTH)
