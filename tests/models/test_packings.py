"""A test on several packings: which sample runs on which, and that all of them are kept."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from graincal import Experiment, InputError, Packing, ParameterSpace, Reference, Samples, TriaxialTest
from graincal._native import LinearLaw
from graincal.campaign import Calibration
from graincal.campaign.stored.store import Store
from graincal.dem.batch import run_batch
from graincal.dem.preparation import OutOfReach
from graincal.dem.siblings import siblings
from graincal.dem.stress_path import drained_triaxial

THETA = [8.0, 0.2, 30.0, 0.1, 0.1]
NAMES = ("log_E", "nu", "phi", "beta_m", "eta_m")
STRAINS = [0.0, 0.002, 0.004]


def cubic(name, shift):
    """A simple cubic packing, whose grains in every other layer are pushed together a little."""
    grid = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * 2e-3
    grid[grid[:, 0] > 1e-3] += [shift, 0, 0]
    return Packing(grid, np.full(27, 1.0001e-3), np.diag([6e-3] * 3), name)


PACKINGS = [cubic("a.csv", 0.0), cubic("b.csv", 4e-6), cubic("c.csv", 8e-6)]
TEST = TriaxialTest(PACKINGS, 2e5)


def outcomes(test, ids, workers=2):
    samples = Samples(np.array(ids), np.tile(THETA, (len(ids), 1)), NAMES)
    found = dict(test.evaluate(samples, STRAINS, workers=workers))
    return [found[row].values for row in range(len(ids))]


def test_a_sample_s_id_says_which_packing_it_runs_on():
    # Bit for bit what each packing gives by itself, with fewer workers than packings too.
    expected = [outcomes(TriaxialTest(packing, 2e5), [0])[0] for packing in PACKINGS]
    assert not np.array_equal(expected[0]["stress_ratio"], expected[1]["stress_ratio"])
    for workers in (1, 8):
        for id, found in zip([7, 3, 5], outcomes(TEST, [7, 3, 5], workers)):
            for name, values in found.items():
                np.testing.assert_array_equal(values, expected[id % 3][name])


def test_all_packings_together_have_as_many_threads_as_are_asked_for():
    threads = set()
    samples = Samples(np.arange(6), np.tile(THETA, (6, 1)), NAMES)
    list(TEST.evaluate(samples, STRAINS, workers=1, watch=lambda id, response: threads.add(threading.get_ident())))
    assert len(threads) == 1


def test_no_thread_waits_while_there_is_a_run_on_any_packing():
    # One run on the first packing and two on the second: those two wait for each other, and whoever is done with the first takes the other.
    both = threading.Barrier(2, timeout=60)

    def watch(id, response):
        if id != 0 and len(response.control) == 1:
            both.wait()

    samples = Samples(np.array([0, 1, 4]), np.tile(THETA, (3, 1)), NAMES)
    assert sorted(row for row, _ in TEST.evaluate(samples, STRAINS, workers=2, watch=watch)) == [0, 1, 2]


def test_the_longest_run_on_any_packing_starts_first():
    a, b, _ = PACKINGS
    twice = Packing(np.vstack([a.positions, a.positions + [0, 0, 6e-3]]), np.tile(a.radii, 2), np.diag([6e-3, 6e-3, 12e-3]), "twice.csv")
    laws = [LinearLaw(1e8, 0.2, 0.5, 0.1, 0.1)] * 5
    runs = run_batch([a, b, twice, a, b], laws, drained_triaxial(2e5, [0.0]), density=2.65e6, expected_steps=[1, 3, 1, 5, 4], threads=1, step_limit=10**6)
    # A step of twice as many particles is twice as long.
    assert [run.index for run in runs] == [3, 4, 1, 2, 0]


def test_several_packings_are_kept_with_a_campaign_and_their_mean_is_emulated():
    reference = Reference(STRAINS, {"stress_ratio": [1.0, 1.5, 1.8]})
    space = ParameterSpace(dict(zip(NAMES, [(7, 9), (0, 0.5), (10, 50), (0, 1), (0, 1)])))
    for test in (TEST, TriaxialTest(PACKINGS[:2], 2e5), TriaxialTest(PACKINGS[0], 2e5)):
        given = Calibration(space, [Experiment("drained", test, reference)], "posterior")
        for calibration in (given, Store.create(given).calibration):
            (experiment,) = calibration.experiments
            (siblings,) = calibration.new_filter().siblings
            # Siblings as large as the packing itself.
            assert (siblings.own, siblings.share) == (len(test.packings), 1.0) and len(experiment.model.packings) == len(test.packings)
            np.testing.assert_array_equal(experiment.model.packings[-1].positions, test.packings[-1].positions)


def test_experiments_on_one_packing_have_its_deviation_in_common():
    reference = Reference(STRAINS, {"stress_ratio": [1.0, 1.5, 1.8]})
    space = ParameterSpace(dict(zip(NAMES, [(7, 9), (0, 0.5), (10, 50), (0, 1), (0, 1)])))
    a, b, _ = PACKINGS
    experiments = [Experiment(name, TriaxialTest(packing, pressure), reference) for name, packing, pressure in (("1", a, 1e5), ("2", b, 1e5), ("3", a, 2e5))]
    assert [each.shared for each in Calibration(space, experiments, "posterior").new_filter().siblings] == [2, 1, 2]


def test_a_copy_at_another_pressure_has_the_packings_and_one_on_another_packing_has_that():
    assert replace(TEST, confining_pressure=4e5).packings == tuple(PACKINGS)
    assert replace(TEST, packing=PACKINGS[1]).packings == (PACKINGS[1],)
    with pytest.raises(InputError, match="a triaxial test needs a packing, or a list of them"):
        TriaxialTest([], 2e5)


def test_a_sample_by_itself_gives_the_same_and_can_be_stopped():
    for id, expected in zip([7, 3], outcomes(TEST, [7, 3])):
        (task,) = TEST.tasks(Samples(np.array([id]), np.array([THETA]), NAMES), STRAINS)
        for name, values in task.work(task.argument).values.items():
            np.testing.assert_array_equal(values, expected[name])
    # With grains so light that their time steps take it tens of seconds.
    endless = TriaxialTest(PACKINGS, 2e5, density_scaling=1e-3, step_limit=10**15)
    (task,) = endless.tasks(Samples(np.array([0]), np.array([THETA]), NAMES), np.linspace(0, 0.5, 100_000))
    stopped, found = threading.Event(), []
    thread = threading.Thread(target=lambda: found.append(task.work.run(task.argument, stopped.is_set)), daemon=True)
    thread.start()
    time.sleep(0.5)
    assert thread.is_alive()
    stopped.set()
    thread.join(60)
    assert not thread.is_alive() and found[0].kind == "cancelled"
    # What moduli differ by, lengths do too: a critical time step goes with the root of the stiffness.
    soft_and_stiff = Samples(np.zeros(2, dtype=int), np.array([THETA, [10.0, *THETA[1:]]]), NAMES)
    soft, stiff = (task.cost for task in TEST.tasks(soft_and_stiff, STRAINS))
    assert stiff / soft == pytest.approx(10)


def test_siblings_are_at_a_void_ratio_that_all_of_their_seeds_reach(monkeypatch):
    # The second seed reaches less than the first, and the third less far down.
    reach, asked = {1: (0.5, 0.72), 2: (0.5, 0.70), 3: (0.55, 0.71)}, []

    def prepare(particles, void_ratio, grading, seed):
        asked.append(void_ratio)
        densest, loosest = reach[seed]
        if not densest <= void_ratio <= loosest:
            raise OutOfReach("out of reach", densest, loosest)
        return void_ratio

    class Like:
        count, radii = 100, np.ones(100)

        def __init__(self, void_ratio):
            self.void_ratio = void_ratio

    monkeypatch.setattr("graincal.dem.siblings.prepare", prepare)
    assert siblings(Like(0.6), 3) == [0.6] * 3
    (loose,) = set(siblings(Like(0.75), 3, threads=2))
    assert 0.69 < loose < 0.70
    (dense,) = set(siblings(Like(0.4), 3))
    assert 0.55 < dense < 0.56
    reach[3] = (0.701, 0.71)
    with pytest.raises(OutOfReach):
        siblings(Like(0.6), 3)
