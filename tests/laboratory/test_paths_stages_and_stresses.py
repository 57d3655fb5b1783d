"""Noisy paths of loading, stages, and stresses in all combinations: what is read from each, and what is refused in which words."""

from __future__ import annotations

import warnings
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from graincal.cli import app
from graincal.data import InputError, Reference
from graincal.laboratory import Known, Understanding, understand
from graincal.laboratory.quantities import STRESS_FORMS
from graincal.laboratory.understanding.staging import _SHEAR


def written(folder: Path, header: str, *columns: object) -> Path:
    path = folder / "lab.csv"
    path.write_text(
        "\n".join([header, *(",".join(cell if isinstance(cell, str) else f"{cell:.6g}" for cell in row) for row in zip(*columns, strict=True))]) + "\n",
        encoding="utf-8",
    )
    return path


def noisy(stresses: np.ndarray, part: float, seed: int) -> np.ndarray:
    return stresses * np.exp(part * np.random.default_rng(seed).standard_normal(len(stresses)))


def settled(steps: np.ndarray, held: int) -> np.ndarray:
    """Void ratios of load steps that settle while they are held."""
    return 0.8 - 0.03 * np.log(steps / 10) + 0.002 * np.tile(np.exp(-np.arange(held) / 3), len(steps) // held)


DENSE, HELD = np.geomspace(10, 1000, 200), np.repeat([10.0, 20, 40, 80, 160, 80, 40, 80, 160, 320], 20)
LOOP = np.concatenate([np.geomspace(10, 300, 100), np.geomspace(300, 100, 40), np.geomspace(100, 1000, 100)])

# stresses, their noise, where they turn around (kPa), how near
PATHS = {
    "smooth": (DENSE, 0.0, [], 0.0),
    "noise of 2 %": (DENSE, 0.02, [], 0.0),
    "many rows with noise of 2 %": (np.geomspace(10, 1000, 1000), 0.02, [], 0.0),
    "few rows with noise of half a percent": (np.geomspace(10, 1000, 40), 0.005, [], 0.0),
    "held load steps": (HELD, 0.0, [160, 40], 1e-12),
    "held load steps with jitter": (HELD, 0.002, [160, 40], 0.01),
    "a loop with noise of 1 %": (LOOP, 0.01, [300, 100], 0.03),
    "a few load steps": (np.array([10.0, 20, 40, 80, 40, 20, 40, 80, 160]), 0.0, [80, 20], 1e-12),
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", PATHS)
def test_a_path_turns_around_where_it_does_and_not_where_it_wavers(name: str, seed: int, tmp_path: Path) -> None:
    stresses, part, turns, near = PATHS[name]
    path = written(tmp_path, "Vertical stress [kPa],Void ratio", noisy(stresses, part, seed), np.linspace(0.8, 0.7, len(stresses)))
    found = understand(path, Known(kind="oedometric"))
    assert found.control == ("position" if turns else "axial_stress")
    np.testing.assert_allclose(found.turns, [1e3 * turn for turn in turns], rtol=near)
    reference = _read(path, found)
    assert np.all(np.diff(reference.control) > 0) and len(reference.control) >= min(len(np.unique(stresses)), 100)


def test_what_a_held_step_comes_to_is_kept(tmp_path: Path) -> None:
    void_ratio = settled(HELD, 20)
    path = written(tmp_path, "Vertical stress [kPa],Void ratio", noisy(HELD, 0.002, 1), void_ratio)
    reference = _read(path, understand(path, Known(kind="oedometric")))
    read = reference.observables["void_ratio"]
    nearest = [np.flatnonzero(np.abs(read - last) < 2e-6) for last in void_ratio[19::20]]
    assert all(len(rows) for rows in nearest)
    assert any("wavers" in note for note in reference.notes)


def test_a_path_that_turns_all_the_time_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, "Vertical stress [kPa],Void ratio", 50 * np.exp(np.sin(np.arange(900) / 2)), np.linspace(0.8, 0.7, 900))
    with pytest.raises(InputError, match="turns around 14. times.*--rows"):
        understand(path, Known(kind="oedometric"))


def _read(path: Path, found: Understanding, pressure: float | None = None):
    """As the calibration file that is proposed."""
    compression = {name: "positive" if sign == "?" else sign for name, sign in found.compression.items()}
    turns = found.turns if found.control == "position" else None
    strain = "engineering" if found.strain else None
    return Reference.read(
        path,
        found.control,
        found.observables,
        columns=found.columns,
        units=found.units,
        compression=compression,
        strain=strain,
        confining_pressure=found.confining_pressure or pressure,
        turns=turns,
    )


N = 12
X = np.linspace(0, 1, N)
Q = 300 * np.sqrt(X)
UNDRAINED = np.stack([400 - (150 + 60 * X - 90 * X**2) + Q, 400 - (150 + 60 * X - 90 * X**2), 150 + 60 * X - 90 * X**2])
DRAINED = np.stack([200 + Q, np.full(N, 200.0), np.full(N, 100.0)])
CONSTANT_P = np.stack([200 + 2 * Q / 3, 200 - Q / 3, np.full(N, 100.0)])
STATES = {"undrained": UNDRAINED, "triaxial": DRAINED, "constant-mean-stress": CONSTANT_P}


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("kind", STATES)
def test_whatever_stresses_are_understood_can_be_read(kind: str, count: int, tmp_path: Path) -> None:
    state, wrong, read = STATES[kind], [], 0
    truth = {"deviatoric_stress": 1e3 * (state[0] - state[1]), "excess_pore_pressure": 1e3 * (state[2] - state[2][0]), "stress_ratio": state[0] / state[1]}
    volume = {} if kind == "undrained" else {"volumetric_strain [%]": X - 4 * X**2}
    for names in combinations(STRESS_FORMS, count):
        columns = {"axial_strain [%]": 20 * X, **volume, **{f"{name} [kPa]": np.array(STRESS_FORMS[name]) @ state for name in names}}
        path = written(tmp_path, ",".join(columns), *columns.values())
        try:
            found = understand(path, Known(kind=kind, strain="engineering", columns={name: (f"{name} [kPa]", None) for name in names}))
        except InputError:
            continue
        try:
            reference = _read(path, found, 1e3 * state[1][0])
            read += 1
            wrong += [
                (names, name)
                for name in set(reference.names) & set(truth)
                if not np.allclose(reference.observables[name], truth[name], rtol=1e-4, atol=1e-4 * np.ptp(truth[name]))
            ]
        except InputError as error:
            wrong.append((names, str(error)))
    assert not wrong and read >= (2 if count == 1 else 40), wrong[:5]


def test_both_stresses_of_an_undrained_test_are_read_from_any_three_that_decide_them(tmp_path: Path) -> None:
    for names in (("total_mean_stress", "total_axial_stress", "pore_pressure"), ("axial_stress", "mean_stress", "pore_pressure")):
        columns = {"axial_strain [%]": 20 * X, **{f"{name} [kPa]": np.array(STRESS_FORMS[name]) @ UNDRAINED for name in names}}
        path = written(tmp_path, ",".join(columns), *columns.values())
        found = understand(path, Known(kind="undrained", columns={name: (f"{name} [kPa]", None) for name in names}))
        assert found.observables == ("deviatoric_stress", "excess_pore_pressure")


@pytest.mark.parametrize(
    ("name", "is_shear"),
    [("Loading", True), ("Shear", True), ("Axial loading", True), ("Compression", True)]
    + [(name, False) for name in ("Unloading", "Reloading", "Preloading", "Un-loading", "re loading", "Offloading", "Consolidation", "Pre-loading")],
)
def test_a_stage_is_the_shear_by_its_own_word(name: str, is_shear: bool) -> None:
    assert bool(_SHEAR.search(name)) == is_shear


STEPS = np.array([12.5, 25, 50, 100, 200, 400, 100, 25])


@pytest.mark.parametrize(
    ("header", "second"),
    [
        ("Stage,Vertical stress [kPa],Void ratio", 0.8 - 0.02 * np.log(STEPS)),
        ("Stage,Vertical stress [kPa],Specific volume", 1.8 - 0.02 * np.log(STEPS)),
        ("Stage,Mean effective stress p' [kPa],Void ratio", 0.8 - 0.02 * np.log(STEPS)),
    ],
)
def test_the_steps_of_a_compression_test_are_no_stages_before_a_shear(header: str, second: np.ndarray, tmp_path: Path) -> None:
    path = written(tmp_path, header, [str(step) for step in range(1, 9)], STEPS, second)
    found = understand(path)
    assert found.stage is None and len(found.table.rows) == 8 and found.control == "position"
    np.testing.assert_allclose(found.turns, [400e3])


@pytest.mark.parametrize("stage", [None, "Shear"])
def test_a_stage_that_stands_in_two_places_is_refused(stage: str | None, tmp_path: Path) -> None:
    names = ["Shear"] * 6 + ["Consolidation"] * 4 + ["Shear"] * 6
    path = written(
        tmp_path, "Stage,axial_strain [%],deviator_stress [kPa],volumetric_strain [%]", names, np.arange(16.0), np.arange(16.0) * 10, np.arange(16.0) / 10
    )
    with pytest.raises(InputError, match=r"Shear stands on lines 2-7 and 12-17.*--rows"):
        understand(path, Known(stage=stage))
    with pytest.raises(InputError, match=r"Shear stands on lines 2-7 and 12-17"):
        Reference.read(path, stage="Shear", confining_pressure=1e5)


# header, stresses, words of the refusal
IMPOSSIBLE = {
    "zeroed": ("axial_strain [%],volumetric_strain [%],sigma1 [kPa],sigma3 [kPa]", (Q + 1, 0 * Q), ["lateral stress is 0"]),
    "another unit": (
        "axial_strain [%],volumetric_strain [%],sigma1 [kPa],sigma3",
        (Q + 200, 0 * Q + 0.2),
        ["'sigma3' (lateral_stress, without a unit and taken in kPa)", "times the lateral one"],
    ),
    "tension": ("axial_strain [%],volumetric_strain [%],sigma1 [kPa],deviator_stress [kPa]", (Q + 10, 2 * Q + 10), ["would fall to"]),
    "contradicting": (
        "axial_strain [%],volumetric_strain [%],sigma1 [kPa],sigma3 [kPa],deviator_stress [kPa]",
        (Q + 200, 0 * Q + 200, Q + 50),
        ["contradict one another"],
    ),
    "no common row": ("axial_strain [%],volumetric_strain [%],sigma1 [kPa],sigma3 [kPa]", (["1", ""] * 6, ["", "1"] * 6), ["no row holds a number in each"]),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_stresses_of_no_test_are_refused_with_the_reason(name: str, tmp_path: Path) -> None:
    header, stresses, words = IMPOSSIBLE[name]
    path = written(tmp_path, header, 20 * X, X - 4 * X**2, *stresses)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        with pytest.raises(InputError) as refused:
            understand(path)
    for word in words:
        assert word in str(refused.value)


# options, words of the refusal: of init, and of predict, which reads the same ones
TWICE = [
    (["--column", "axial_strain=1", "--column", "axial_strain=2"], "--column names axial_strain twice"),
    (["--column", "axial_strain=1", "--column", "deviator_stress=1:kPa"], "named for"),
    (["--column", "deviator_stress=3:kPa", "--column", "q=3:kPa"], "deviator_stress twice, once as q"),
    (["--compression", "axial_strain=positive", "--compression", "axial_strain=negative"], "--compression names axial_strain twice"),
    (["--column", "axial_strain=²"], "there is no column '²'"),
]


@pytest.mark.parametrize(("options", "words"), TWICE)
def test_what_is_said_twice_is_refused(options: list[str], words: str, tmp_path: Path) -> None:
    path = written(tmp_path, "axial_strain [%],volumetric_strain [%],deviator_stress [kPa]", 20 * X, X - 4 * X**2, Q)
    result = CliRunner().invoke(app, ["init", str(path), *options, "-o", str(tmp_path / "calibration.toml")])
    assert result.exit_code != 0 and words in " ".join((str(result.exception) + result.output).split())


def test_an_initial_void_ratio_is_named_as_a_fraction(tmp_path: Path) -> None:
    path = written(tmp_path, "axial_strain [%],volumetric_strain [%],deviator_stress [kPa],before", 20 * X, X - 4 * X**2, Q, np.full(N, 0.71))
    found = understand(path, Known(confining_pressure=1e5, columns={"initial_void_ratio": (4, "-")}))
    assert found.void_ratio == pytest.approx(0.71)
