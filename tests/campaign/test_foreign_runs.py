"""Runs of another tool teach a campaign's emulator and carry no weight: `graincal import grainlearning`."""

import shutil

import numpy as np
import pytest
from grainlearning.files import write_npy, write_table, write_text

import graincal as gc
from graincal.campaign.found.status import status
from graincal.campaign.stored.store import Store

from .hyperbola import SPACE, STRAIN, THE_PAPERS, TRUTH, respond, write_calibration
from .test_by_hand import FUNCTION, NO_CRITERIA

pytestmark = pytest.mark.usefixtures("fewer_draws")

POSTERIOR = (THE_PAPERS, 'method = "posterior"\nfirst_batch = 20\nbatch = 4')
THETA = np.random.default_rng(1).uniform(0, 0.75, (40, 2))


def kept_runs(folder, theta=THETA, names=SPACE.names, control="axial_strain", text=False):
    """A folder of GrainLearning's with a run at each theta."""
    inner = folder / "sim_data" / "iter0"
    inner.mkdir(parents=True)
    write_table(inner / "smcTable0.txt", names, theta)
    for row, values in enumerate(theta):
        content = ({control: STRAIN} if control else {}) | respond(values[:2])
        if text:
            write_text(inner / f"soil_Iter0_Sample{row:02d}_sim.txt", content)
        else:
            write_npy(inner / f"soil_Iter0_Sample{row:02d}.npy", content | dict(zip(names, values)))
    return folder / "sim_data"


def known_of(campaign):
    return Store.open(campaign).calibration.known


@pytest.mark.parametrize("text", [False, True])
def test_a_campaign_goes_on_from_them(call, tmp_path, text):
    file = write_calibration(tmp_path, POSTERIOR, NO_CRITERIA, ("max_iterations = 3", "max_iterations = 2"))
    called = call("import", "grainlearning", kept_runs(tmp_path, text=text), file, "-o", tmp_path / "campaign")
    assert (
        called.code == 0
        and "Learns from 40 runs of" in called.out
        and "That its model is the same is taken on trust." in called.out
        and called.out.endswith(f"graincal resume {tmp_path / 'campaign'}\n")
    )
    known = known_of(tmp_path / "campaign")
    np.testing.assert_allclose(known.theta, THETA, rtol=1e-9)
    for theta, curve in zip(THETA, known.responses[0]):
        np.testing.assert_allclose(curve, np.stack([respond(theta)[name] for name in ("stress_ratio", "volumetric_strain")], axis=1), rtol=1e-12, atol=1e-15)
    assert status(tmp_path / "campaign")["state"] == "interrupted"
    assert call("resume", tmp_path / "campaign").code == 0
    result = gc.Result.read(tmp_path / "campaign")
    # Most of the ranges are known: fewer runs fill them than without. Those that are known are no evaluations, and are not the answer.
    assert len(result.iterations[0].samples) < 20 and result.evaluations < 40
    np.testing.assert_allclose(result.posterior.mean(), TRUTH, atol=0.05)
    assert "which GrainLearning kept" in (tmp_path / "campaign" / "campaign.toml").read_text().splitlines()[0]


def test_by_hand_it_goes_on_too_with_columns_as_they_are_declared(call, tmp_path):
    model = 'kind = "by-hand", output = { columns = { axial_strain = "e_z", stress_ratio = "stress_ratio", volumetric_strain = "volumetric_strain" } }'
    file = write_calibration(tmp_path, POSTERIOR, NO_CRITERIA, (FUNCTION, model))
    assert call("import", "grainlearning", kept_runs(tmp_path, control="e_z"), file, "-o", tmp_path / "campaign").code == 0
    assert "no run waits; go on with the campaign by: graincal resume" in call("ask", tmp_path / "campaign").err
    assert "runs wait to be made by hand" in call("resume", tmp_path / "campaign").out and call("ask", tmp_path / "campaign").code == 0


def test_without_a_control_they_are_at_the_references_own_rows(call, tmp_path):
    file = write_calibration(tmp_path, POSTERIOR, NO_CRITERIA)
    called = call("import", "grainlearning", kept_runs(tmp_path, control=None), file, "-o", tmp_path / "campaign")
    assert called.code == 0 and "Its files hold no axial_strain: the curves are taken to be at the reference's own rows." in called.out
    assert len(known_of(tmp_path / "campaign")) == 40


def test_parameters_and_columns_may_have_other_names(call, tmp_path):
    runs = kept_runs(tmp_path, np.column_stack([THETA, np.full(40, 3.0)]), ("s", "d", "density"), control="e")
    file = write_calibration(tmp_path, POSTERIOR, NO_CRITERIA)
    options = ["--parameter", "strength=s", "--parameter", "dilatancy=sqrt(d**2)", "--column", "axial_strain=e"]
    called = call("import", "grainlearning", runs, file, "-o", tmp_path / "campaign", *options)
    assert called.code == 0 and "All its runs have density = 3." in called.out, called.err
    np.testing.assert_allclose(known_of(tmp_path / "campaign").theta, THETA, rtol=1e-9)


def test_curves_of_another_size_are_said(call, tmp_path):
    file, runs = write_calibration(tmp_path, POSTERIOR, NO_CRITERIA), kept_runs(tmp_path)
    called = call("import", "grainlearning", runs, file, "-o", tmp_path / "campaign", "--column", "volumetric_strain=volumetric_strain:%")
    assert called.code == 0 and "The largest volumetric_strain of its runs is" in called.out and "another unit may be meant" in called.out
    assert "The largest" not in call("import", "grainlearning", runs, file, "-o", tmp_path / "right").out


def test_what_cannot_be_learnt_from_is_counted(call, tmp_path):
    runs = kept_runs(tmp_path, np.concatenate([THETA[:10], [[1.2, 0.1]]])) / "iter0"
    good = respond(THETA[1]) | dict(zip(SPACE.names, THETA[1]))
    write_npy(
        runs / "soil_Iter0_Sample01.npy", {"axial_strain": STRAIN[:8]} | {name: values[:8] if np.ndim(values) else values for name, values in good.items()}
    )
    write_npy(
        runs / "soil_Iter0_Sample02.npy",
        {"axial_strain": STRAIN} | respond(THETA[2]) | dict(zip(SPACE.names, THETA[2])) | {"stress_ratio": np.full(11, np.nan)},
    )
    shutil.copy(runs / "soil_Iter0_Sample03.npy", runs / "soil_Iter0_Sample04.npy")
    (runs / "soil_Iter0_Sample05.npy").unlink()
    called = call("import", "grainlearning", runs, write_calibration(tmp_path, POSTERIOR, NO_CRITERIA), "-o", tmp_path / "campaign")
    assert called.code == 0 and "Learns from 6 runs" in called.out
    for said in (
        "1 of a table without a file",
        "1 shorter than the reference",
        "1 not finite at the reference's rows",
        "1 with other parameters than their table has",
        "1 at strength outside 0 to 1",
    ):
        assert said in called.out, said


def test_outside_a_range_of_many_decades_is_by_the_logarithm(call, tmp_path):
    theta = np.array([[0.5, 0.1], [-1e-7, 0.2], [1e-6, 0.3], [1e-4, 0.4]])
    wide = ("strength  = { range = [0, 1] }", 'strength  = { range = [1e-4, 1e7], scale = "log" }')
    called = call("import", "grainlearning", kept_runs(tmp_path, theta), write_calibration(tmp_path, POSTERIOR, NO_CRITERIA, wide), "-o", tmp_path / "campaign")
    assert called.code == 0 and "Learns from 2 runs" in called.out and "2 at strength outside" in called.out, called.out + called.err


@pytest.mark.parametrize(
    "changes, options, said",
    [
        ([], [], 'filter.method is "iterative-bayesian", and "posterior" was expected'),
        ([POSTERIOR, NO_CRITERIA, ("strength  = { range = [0, 1] }", "E = { range = [0, 1] }")], [], "it has no parameter E, and holds strength, dilatancy"),
        ([POSTERIOR, NO_CRITERIA, ("strength  = { range = [0, 1] }\n", "")], [], "its runs differ in strength, which the calibration does not have"),
        ([POSTERIOR, NO_CRITERIA], ["--column", "stress_ratio=q"], "has no 'q'"),
        ([POSTERIOR, NO_CRITERIA], ["--column", "stress_ratio=q"], "; --column QUANTITY=COLUMN says which column is which quantity."),
        ([POSTERIOR, NO_CRITERIA], ["--column", "stress=q"], "--column names stress"),
        ([POSTERIOR, NO_CRITERIA], ["--parameter", "strength=open(1)"], "there is no function open"),
        ([POSTERIOR, NO_CRITERIA], ["--parameter", "strength"], "--parameter must be a parameter and an expression"),
        (
            [POSTERIOR, NO_CRITERIA, (FUNCTION, 'kind = "triaxial", particles = 200, void_ratio = 0.7, confining_pressure = 1e5, fixed = { nu = 0.2 }')],
            [],
            "strength",
        ),
    ],
)
def test_what_cannot_be_is_said(call, tmp_path, changes, options, said):
    called = call("import", "grainlearning", kept_runs(tmp_path, THETA[:3]), write_calibration(tmp_path, *changes), "-o", tmp_path / "campaign", *options)
    assert called.code == 1 and said in called.err and not (tmp_path / "campaign").exists(), called.err


def test_what_the_prior_holds_impossible_is_left_out(call, tmp_path):
    first, second = SPACE.names
    file = write_calibration(tmp_path, POSTERIOR, ("[parameters]", f'[[constraint]]\nrequire = "{first} < {second}"\n\n[parameters]'))
    called = call("import", "grainlearning", kept_runs(tmp_path), file, "-o", tmp_path / "campaign")
    met = THETA[THETA[:, 0] < THETA[:, 1]]
    assert (
        called.code == 0
        and f"Learns from {len(met)} runs of" in called.out
        and f"left out: {len(THETA) - len(met)} where a constraint does not hold" in called.out
    )
    np.testing.assert_allclose(known_of(tmp_path / "campaign").theta, met, rtol=1e-9)


def test_the_command_has_help(call):
    called = call("import", "grainlearning", "--help")
    assert called.code == 0 and "Example:  graincal import grainlearning" in called.out
