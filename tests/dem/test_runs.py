"""Runs of the built-in test on the engine's threads: their results depend on nothing but themselves, and what goes wrong is an outcome with its reason."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from graincal import Failure, InputError, Packing, Response, Samples, TriaxialTest, _native, demo
from graincal.dem.batch import run_batch
from graincal.dem.stress_path import drained_triaxial
from graincal.interpolation import interpolate
from graincal.models.contact_laws import LAWS

from .spheres import law, rounding

THETAS = np.array(
    [
        [8.5, 0.20, 30.0, 0.10, 0.50],
        [8.8, 0.10, 20.0, 0.00, 0.00],
        [8.2, 0.40, 45.0, 0.80, 0.90],
        [8.6, 0.00, 10.0, 0.30, 0.20],
        [8.3, 0.30, 0.0, 0.10, 0.10],
        [9.0, 0.25, 35.0, 0.05, 0.30],
    ]
)
STRAINS = [0.0, 0.002, 0.004, 0.008]

LONGEST = 300_000
"""Steps that no run here comes near: an engine that never finds rest fails within seconds."""


RESTS = 7
"""At which the test comes to rest on its way through STRAINS."""


def triaxial(packing, pressure=1e5, step_limit=LONGEST, accuracy="reference", **options):
    return TriaxialTest(packing, pressure, step_limit=step_limit, accuracy=accuracy, **options)


def assert_identical(one, other):
    """Bit for bit the same curve after the same number of steps."""
    assert one.values.keys() == other.values.keys()
    for name, values in one.values.items():
        assert np.array_equal(values, other.values[name]), name
    assert one.details["steps"] == other.details["steps"]


# The same whatever runs beside


def curves_of(packing, **options):
    outcomes = triaxial(packing, **options).simulate(THETAS, at=STRAINS, threads=1)
    assert all(isinstance(outcome, Response) for outcome in outcomes)
    return outcomes


@pytest.fixture(scope="module")
def curves(packing):
    return curves_of(packing)


@pytest.fixture(scope="module")
def hertz_curves(packing):
    return curves_of(packing, law="hertz-mindlin")


@pytest.fixture(scope="module")
def single_curves(packing):
    return curves_of(packing, precision="float32")


def test_runs_are_bitwise_the_same_with_one_thread_and_with_two(packing, curves):
    for one, two in zip(curves, triaxial(packing).simulate(THETAS, at=STRAINS, threads=2)):
        assert_identical(one, two)


def test_hertz_runs_are_bitwise_the_same_with_two_threads_and_in_another_order(packing, hertz_curves):
    for one, two in zip(hertz_curves[::-1], triaxial(packing, law="hertz-mindlin").simulate(THETAS[::-1], at=STRAINS, threads=2)):
        assert_identical(one, two)


def test_float32_runs_are_bitwise_the_same_with_two_threads_and_in_another_order(packing, single_curves):
    for one, two in zip(single_curves[::-1], triaxial(packing, precision="float32").simulate(THETAS[::-1], at=STRAINS, threads=2)):
        assert_identical(one, two)


def test_each_precision_rounds_by_itself_and_finds_the_same_soil(curves, single_curves):
    for theta, double, single in zip(THETAS, curves, single_curves):
        assert not np.array_equal(double.values["stress_ratio"], single.values["stress_ratio"])
        # The shear of a hundred grains is chaotic from its first percent on; compressed they are to a thousandth of the pressure, and a stiffness of some
        # hundreds of pressures makes less than that of the volume. Without friction nothing keeps grains from settling on: replicates whose density differs
        # by a percent scatter by half a percent.
        frictionless = theta[2] == 0
        assert single.values["void_ratio"][0] == pytest.approx(double.values["void_ratio"][0], rel=1e-2 if frictionless else 1e-3)


def test_each_law_has_curves_of_its_own(curves, hertz_curves):
    for linear, hertz in zip(curves, hertz_curves):
        assert not np.allclose(linear.values["stress_ratio"][1:], hertz.values["stress_ratio"][1:], rtol=1e-3)


@pytest.mark.parametrize("kind", ["linear", "hertz-mindlin"])
def test_runs_are_bitwise_the_same_with_every_instruction_set_of_this_machine(packing, kind, precision):
    # Multiply-adds are never contracted and sums never reordered.
    held = _native.Packing(packing.positions, packing.radii, packing.edges)
    grains = law(modulus=1e9, friction=0.4, rolling_strength=0.3, kind=kind)
    outcomes = []
    for name in _native.instruction_sets:
        batch = _native.Batch([held], [grains], 2.65e6, drained_triaxial(1e5, STRAINS), [0], 1, LONGEST, name, precision)
        outcomes.append(batch.next(600.0))
    for outcome in outcomes:
        assert outcome["status"] == "finished" and outcome["steps"] == outcomes[0]["steps"]
        for name, column in outcome["columns"].items():
            assert np.array_equal(column, outcomes[0]["columns"][name]), name


def test_a_precision_that_is_not_compiled_is_refused(packing):
    with pytest.raises(TypeError, match="precision"):
        _native.Simulation(packing.positions, packing.radii, packing.edges, law(), 1.0, precision="float16")


def test_runs_are_bitwise_the_same_in_any_order_and_alone(packing, curves):
    test = triaxial(packing)
    order = [3, 0, 5, 1, 4, 2]
    for row, outcome in zip(order, test.simulate(THETAS[order], at=STRAINS, threads=2)):
        assert_identical(curves[row], outcome)
    assert_identical(curves[2], test.simulate(THETAS[2], at=STRAINS, threads=1)[0])


def test_each_sample_comes_back_once(packing):
    samples = Samples(np.arange(10, 16), THETAS, LAWS["linear"].names)
    rows = [row for row, _ in triaxial(packing).evaluate(samples, at=STRAINS, workers=2)]
    assert sorted(rows) == list(range(6))


def test_curves_are_recorded_at_the_strains_asked_for(curves):
    for outcome in curves:
        # The servo's tolerance of strain; at rest within a thousandth of the pressure.
        assert np.allclose(outcome.values["axial_strain"], STRAINS, rtol=0, atol=1e-6)
        assert outcome.values["stress_ratio"][0] == pytest.approx(1, abs=2e-3)
        assert np.all(outcome.values["unbalanced_force"] < 1e-3)
        lateral = outcome.values["mean_stress"] - outcome.values["deviatoric_stress"] / 3
        assert np.allclose(lateral, 1e5, rtol=1e-3, atol=0)
        assert outcome.details["flagged"] == 0 and np.all(np.diff(outcome.values["steps"]) > 0)


def test_a_run_that_is_timed_pass_by_pass_takes_the_steps_of_one_that_is_not(packing, precision):
    held = _native.Packing(packing.positions, packing.radii, packing.edges)
    grains, stages = law(modulus=1e9, friction=0.4, rolling_strength=0.3), drained_triaxial(1e5, STRAINS)
    batch = _native.Batch([held], [grains], 2.65e6, stages, [0], 1, LONGEST, precision=precision)
    timed = _native.time_passes(held, grains, 2.65e6, stages, precision=precision)
    assert timed["steps"] == batch.next(600.0)["steps"]
    assert all(seconds > 0 for seconds in timed["seconds"].values())


def is_reached(goal, stress, strain):
    """What the path asks of an axis: strain to 1e-6, stress to a thousandth."""
    controls_stress, target, _ = goal
    return abs(stress - target) <= 1e-3 * target if controls_stress else abs(strain - target) <= 1e-6


@pytest.mark.parametrize("goal", [(False, 0.005, 0.5), (True, 1.5e5, 0.01)], ids=["strain", "stress"])
def test_a_batch_takes_the_steps_that_a_simulation_by_hand_takes(packing, goal, precision):
    # A batch runs the same step compiled for the machine's own instruction set: all that is tested on single simulations holds for it if the two agree. Here
    # they squeeze the packing, wait for rest, change the damping and record at the next rest. The stress is sought so slowly that it is what is waited for.
    density = 2.65e6
    goals = [_native.AxisGoal(*goal)] * 3
    held = _native.Packing(packing.positions, packing.radii, packing.edges)
    grains = law(modulus=1e9, friction=0.4, rolling_strength=0.3)
    batch = _native.Batch([held], [grains], density, [_native.Stage(goals, record=True)], [0], 1, LONGEST, precision=precision)
    outcome = batch.next(600.0)
    recorded = {name: column[0] for name, column in outcome["columns"].items()}

    simulation = _native.Simulation(packing.positions, packing.radii, packing.edges, grains, density, precision=precision)
    simulation.set_goals(goals)
    damping, rests = 0.2, 0
    while rests < 2:
        before = simulation.copy()
        simulation.run(1, damping)
        strains = np.log(np.diag(packing.edges) / np.diag(before.edges))
        stresses = simulation.stress_diagonal[0]
        if all(is_reached(goal, *axis) for axis in zip(stresses, strains)) and simulation.unbalanced_force < 1e-3:
            rests += 1
            if rests == 1:  # the step that finds the packing at rest moves it with the heavier damping already
                damping, simulation = 0.9, before
                simulation.run(1, damping)
        assert simulation.steps < outcome["steps"] + 100
    assert recorded["steps"] == before.steps
    # Other instructions may round otherwise, and collisions carry roundings on; resultants are a thousandth of the forces that they are left over from.
    assert recorded["unbalanced_force"] == pytest.approx(simulation.unbalanced_force, rel=1e-6 + 1e3 * rounding(precision))
    assert recorded["contacts"] == len(simulation.contacts()["first"])
    assert np.allclose([recorded[f"stress_{axis}"] for axis in ("xx", "yy", "zz")], stresses, rtol=1e-9 + 10 * rounding(precision), atol=0)


# What goes wrong


def outcome_of(packing, theta, at=STRAINS, pressure=1e5, **options):
    return triaxial(packing, pressure, **options).simulate([theta], at=at, threads=1)[0]


def assert_failed(outcome, kind, reason):
    assert isinstance(outcome, Failure) and outcome.kind == kind
    assert reason in outcome.reason and outcome.reason.endswith(".") and "\n" not in outcome.reason
    assert outcome.details["steps"] >= 0


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("log_E", np.nan, "log_E = nan has no meaning, it must be a number at least 0 and below 20"),
        ("nu", -1.0, "nu = -1 has no meaning, it must be a number at least 0"),
        ("phi", 90.0, "phi = 90 has no meaning, it must be a number at least 0 and below 90"),
        ("beta_m", -0.1, "beta_m"),
        ("eta_m", np.inf, "eta_m"),
    ],
)
def test_a_parameter_without_meaning_is_a_failure(packing, name, value, expected):
    theta = dict(zip(LAWS["linear"].names, THETAS[0])) | {name: value}
    assert_failed(outcome_of(packing, list(theta.values())), "parameters", expected)


def test_poissons_ratio_is_below_a_half(packing):
    assert_failed(
        outcome_of(packing, [9.0, 0.5, 30.0, 0.1, 0.5], law="hertz-mindlin"),
        "parameters",
        "nu = 0.5 has no meaning, it must be a number at least 0 and below 0.5",
    )


@pytest.mark.parametrize("stiffness_ratio", [-1.0, np.nan])
def test_a_motion_that_runs_away_ends_the_run(packing, stiffness_ratio):
    # A spring that pushes the further it is pushed, and friction that never lets go; or forces that are no numbers.
    grains = law(modulus=10**8.5, stiffness_ratio=stiffness_ratio, friction=1e3)
    (run,) = run_batch(packing, [grains], drained_triaxial(1e5, [0.0]), density=2.65e6, expected_steps=[1], threads=1, step_limit=LONGEST)
    assert run.status == "diverged"


@pytest.mark.parametrize("theta", [[7.0, 0.05, 0.0, 0.0, 0.0], [7.0, 0.2, 0.0, 0.5, 0.5], [7.0, 0.01, 30.0, 0.5, 0.5]])
def test_soft_grains_compressed_fast_do_not_count_as_running_away(theta):
    # The softest corner of the paper's ranges: steps are long, and grains cross up to a quarter of the smallest radius in one. YADE brings them to rest.
    outcome = outcome_of(demo.packing(), theta, at=[0.0], pressure=0.5e6)
    assert isinstance(outcome, Response) and outcome.details["flagged"] == 0 and 0.24 < outcome.values["void_ratio"][0] < 0.27


@pytest.mark.parametrize("at", [[], [[0.0, 0.1]], [0.0, np.nan], [0.0, 20.0], ["a"]])
def test_strains_that_are_no_row_of_fractions_are_refused(packing, at):
    with pytest.raises(InputError, match="one row of fractions"):
        triaxial(packing).evaluate(Samples(np.arange(6), THETAS, LAWS["linear"].names), at)


@pytest.mark.parametrize(
    "wrong",
    [
        {"fixed": {"phi": "x"}},
        {"fixed": {"phi": 120.0}},
        {"step_limit": -1},
        {"largest_flagged_share": np.nan},
        {"density_scaling": 0.0},
        {"law": "hertz"},
        {"precision": "float16"},
    ],
)
def test_a_test_that_cannot_be_run_is_refused(packing, wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        TriaxialTest(packing, 1e5, **wrong)


def test_a_step_beyond_the_critical_one_runs_away(packing):
    simulation = _native.Simulation(packing.positions, packing.radii, packing.edges, law(modulus=1e9), 2.65e6)
    simulation.run(1, 0.0)
    with pytest.raises(RuntimeError, match="ran away"):
        simulation.run_prescribed(10_000, np.zeros((3, 3)), 5 * simulation.time_step, 0.0)


def test_a_sample_crushed_below_its_smallest_cell_ends_as_a_failure(packing):
    assert_failed(outcome_of(packing, [8.5, 0.2, 30, 0.1, 0.5], pressure=1e12), "cell_too_small", "too small for its largest particles")


def test_a_run_longer_than_its_limit_ends_as_a_failure(packing):
    assert_failed(outcome_of(packing, THETAS[0], step_limit=200), "out_of_steps", "reached its limit of 200 steps")


def test_a_failure_leaves_the_runs_beside_it_alone(packing, curves):
    thetas = np.vstack([THETAS[:2], [np.nan, 0.2, 30, 0.1, 0.5], THETAS[2:]])
    outcomes = triaxial(packing).simulate(thetas, at=STRAINS, threads=2)
    assert_failed(outcomes.pop(2), "parameters", "log_E")
    for one, other in zip(curves, outcomes):
        assert_identical(one, other)


APART = Packing(np.array([[1.0, 1, 1], [1, 1, 5]]), np.ones(2), np.diag([8.0] * 3))
"""Two spheres that touch nothing."""


def endless(tasks, threads):
    """Arguments of a batch of simulations that are driven to a strain at a rate of nothing."""
    held = _native.Packing(APART.positions, APART.radii, APART.edges)
    never = [_native.Stage([_native.AxisGoal(stress=False, target=0.1, largest_rate=0.0)] * 3)]
    return [held], [law()] * tasks, 1.0, never, list(range(tasks)), threads, 10**15


def test_a_batch_can_be_stopped():
    batch = _native.Batch(*endless(3, threads=2))
    assert batch.next(0.01) is None
    batch.cancel()
    outcomes = [batch.next(60.0) for _ in range(3)]
    assert sorted(outcome["task"] for outcome in outcomes) == [0, 1, 2]
    assert {outcome["status"] for outcome in outcomes} == {"cancelled"}


def test_a_batch_whose_task_cannot_be_made_says_so_to_who_waits():
    packings, laws, density, stages, _, threads, limit = endless(3, threads=2)
    batch = _native.Batch(packings, laws, density, stages, [0, 3, 1, 2], threads, limit)  # there is no fourth law
    with pytest.raises(IndexError):
        batch.next(60.0)
    # The others are ended, and come as they would otherwise.
    assert sorted((outcome["task"], outcome["status"]) for outcome in (batch.next(60.0) for _ in range(3))) == [(task, "cancelled") for task in range(3)]
    assert batch.next(0.0) is None


THREADS_THAT_DO_NOT_START = """
import resource
import numpy as np
from graincal import Packing, _native
from graincal.dem.batch import run_batch

apart = Packing(np.array([[1.0, 1, 1], [1, 1, 5]]), np.ones(2), np.diag([8.0] * 3))
held = _native.Packing(apart.positions, apart.radii, apart.edges)
laws = [_native.LinearLaw(1e7, 0.3, 0.0, 0.0, 0.0)] * 8
never = [_native.Stage([_native.AxisGoal(stress=False, target=0.1, largest_rate=0.0)] * 3)]
taken = int(next(line for line in open("/proc/self/status") if line.startswith("VmSize")).split()[1]) * 1024
resource.setrlimit(resource.RLIMIT_AS, (taken + 300_000_000, resource.RLIM_INFINITY))
try:
    _native.Batch([held], laws, 1.0, never, list(range(8)), 8, 10**15)
except RuntimeError as error:
    print(error)
try:
    next(run_batch(apart, laws, never, density=1.0, expected_steps=range(8), threads=8, step_limit=10**15))
except ValueError as error:
    print(error)
batch = _native.Batch([held], laws, 1.0, never, list(range(8)), 2, 10**15)
batch.cancel()
print(batch.next(60.0)["status"])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="how much a process takes is limited and told otherwise elsewhere")
def test_threads_that_cannot_be_started_are_an_error_in_words():
    # Each thread reserves 64 MB of addresses for its stack, and the limit leaves room for four. What did start has ended: two find room again.
    command = ["sh", "-c", 'ulimit -s 65536 && exec "$0" -c "$1"', sys.executable, THREADS_THAT_DO_NOT_START]
    ended = subprocess.run(command, capture_output=True, text=True, env=os.environ | {"MALLOC_ARENA_MAX": "1"}, timeout=120)
    assert ended.returncode == 0, ended.stderr
    by_the_engine, to_the_user, again = ended.stdout.splitlines()
    assert re.fullmatch(r"only [1-7] of 8 threads could be started \(.+\)", by_the_engine)
    assert to_the_user == f"workers: {by_the_engine}, and a number that the system has room for was expected."
    assert again == "cancelled"


# Runs that are watched


@pytest.mark.parametrize("workers", [1, 3])
def test_who_watches_is_shown_the_states_so_far_and_can_stop_a_run(packing, curves, workers):
    shown = {10: [], 11: [], 12: []}

    def watch(id, response):
        shown[id].append(response)
        return id == 11 and len(response.control) == 2

    samples = Samples(np.array([10, 11, 12]), THETAS[:3], LAWS["linear"].names)
    outcomes = dict(triaxial(packing).evaluate(samples, STRAINS, workers=workers, watch=watch))
    for row in (0, 2):
        assert_identical(interpolate(outcomes[row], np.array(STRAINS)), curves[row])
        # With the last state the run is at its end, and there is nothing to decide.
        assert [len(response.control) for response in shown[10 + row]] == list(range(1, RESTS))
    stopped = outcomes[1]
    assert stopped.stopped and not outcomes[0].stopped and len(shown[11]) == 2
    assert list(stopped.control) == [0.0, 0.0005] and stopped.details["steps"] < curves[1].details["steps"]
    for name, values in stopped.values.items():
        assert values[0] == curves[1].values[name][0], name
        assert np.array_equal(values, shown[11][-1].values[name]), name


def test_what_a_watch_raises_is_raised_by_who_waits(packing):
    def watch(id, response):
        raise ArithmeticError(f"sample {id} cannot be looked at")

    samples = Samples(np.arange(3), THETAS[:3], LAWS["linear"].names)
    with pytest.raises(ArithmeticError, match="cannot be looked at"):
        list(triaxial(packing).evaluate(samples, STRAINS, workers=2, watch=watch))


@pytest.mark.parametrize(("looked_at", "error"), [(lambda: {}["nothing"], KeyError), (lambda: sys.exit(3), SystemExit), (lambda: np.ones(2), ValueError)])
def test_what_is_no_answer_to_whether_a_run_stops_is_raised_by_the_batch(packing, looked_at, error):
    # A row of truths is neither true nor false.
    stages = drained_triaxial(1e5, STRAINS)
    held = _native.Packing(packing.positions, packing.radii, packing.edges)
    batch = _native.Batch([held], [law(modulus=1e9)] * 2, 2.65e6, stages, [0, 1], 1, LONGEST, watch=lambda task, columns: looked_at())
    with pytest.raises(error):
        batch.next(60.0)
    # The run that was looked at has no outcome, and the other never began.
    assert batch.next(60.0)["status"] == "cancelled" and batch.next(0.0) is None


def test_a_batch_that_is_given_up_while_it_is_watched_ends(packing):
    # Its threads may be waiting for the interpreter, to show a state, while it waits for them.
    for _ in range(20):
        runs = triaxial(packing).evaluate(
            Samples(np.arange(6), THETAS, LAWS["linear"].names), STRAINS, workers=4, watch=lambda id, response: len(response.control) == 1
        )
        next(runs)
        runs.close()


# States not at rest

RESTLESS = [10.0, 0.2, 0.0, 0.0, 0.0]
"""Without friction, at a hundredth of the pressure it was made at, the packing hardly holds together and its grains go on jumping: so hard, none of four
density scalings within three percent of one another came to rest, where a tenth of the modulus did."""


@pytest.fixture(scope="module")
def restless(packing):
    # A state that is flagged is a share of one; all may be flagged and the response still stands.
    return outcome_of(packing, RESTLESS, at=[0.0005], pressure=1e3, largest_flagged_share=1.0, density_scaling=1e3)


def test_a_state_not_at_rest_within_its_limit_is_recorded_and_flagged(restless):
    assert isinstance(restless, Response)
    assert restless.details["flagged"] >= 1 and np.array_equal(restless.values["flagged"], [1])
    assert restless.values["unbalanced_force"][0] > 1e-3
    assert restless.values["axial_strain"][0] == pytest.approx(0.0005, abs=1e-6)
    # 25,000 steps of patience, after the isotropic stage.
    assert restless.details["steps"] > 25_000


def test_more_flagged_states_than_allowed_are_a_failure(packing):
    test = triaxial(packing, 1e3, density_scaling=1e3)
    assert test.largest_flagged_share == 0.1
    outcome = test.simulate([RESTLESS], at=[0.0005], threads=1)[0]
    flagged = int(outcome.details["flagged"])
    # It ends as soon as it can only fail.
    assert flagged == outcome.details["states"] == 1
    assert_failed(outcome, "flagged", "1 of the first 1 states were not at rest within their step limit, more than the share of 0.1 of all 2 that is allowed.")


def test_no_share_of_flagged_states_exceeds_one(packing):
    # Stiffer still, the isotropic stage does not come to rest either; it is not a state of the curve, and said apart.
    stiffer = triaxial(packing, 1e3, largest_flagged_share=1.0, density_scaling=1e3)
    outcome = stiffer.simulate([[11.0, 0.0, 0.0, 0.0, 0.0]], at=[0.0], threads=1)[0]
    assert isinstance(outcome, Response) and outcome.details["flagged"] == 1 and outcome.details["consolidation_flagged"] == 1


def test_a_stress_that_is_never_held_ends_within_its_limit(packing):
    # Hard and frictionless, the stresses ring about the target and meet it on no two axes at once; each has crossed it within the first thousand steps.
    outcome = outcome_of(packing, [11.0, 0.227, 0.0, 0.0, 0.0], at=[0.0], pressure=1e5, largest_flagged_share=1.0)
    assert isinstance(outcome, Response) and outcome.details["steps"] < 100_000


def test_a_packing_without_neighbours_can_be_run():
    # Two spheres apart have no critical step and no stress: the cell closes on them until it is too small.
    assert_failed(outcome_of(APART, THETAS[0]), "cell_too_small", "too small")
