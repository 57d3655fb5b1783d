"""Files by closed-form curves: what is stated or provable is read rightly, and what is not is asked about. `generated` says how they are made."""

import csv
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from generated.cases import DECIDABLE, DEPRIVED, OPEN_TO_BOTH, Case, cases
from generated.curves import Array
from generated.deprived import ASKED, OPEN, TAKEN
from generated.outcome import Outcome, differences, read
from generated.packing import packing
from generated.units import FRACTIONS, PRESSURES
from generated.words import CANONICAL, ENGLISH

ASKED_AT_MOST = 0.05
"""Of the decidable files."""


def outcomes(group: str, folder: Path, name: str | None = None) -> list[tuple[Case, Outcome]]:
    return [(case, case.outcome(folder)) for case in cases() if case.group == group and name in (None, case.name)]


def offenders(found: list[tuple[Case, Outcome]], *allowed: str) -> list[str]:
    return [" ".join(f"{case.title}: {outcome.verdict}: {outcome.why}".split())[:600] for case, outcome in found if outcome.verdict not in allowed]


def in_lines(said: list[str]) -> str:
    return "\n".join([f"{len(said)} files:", *said])


def test_a_decidable_file_is_read_rightly_and_never_wrongly(tmp_path: Path) -> None:
    found = outcomes(DECIDABLE, tmp_path)
    wrong, not_right = offenders(found, "RIGHT", "ASKED", "LACKING"), offenders(found, "RIGHT")
    assert not wrong, in_lines(wrong)
    assert len(not_right) <= ASKED_AT_MOST * len(found), in_lines(not_right)


@pytest.mark.parametrize("name", TAKEN)
def test_an_undecidable_file_is_asked_about(name: str, tmp_path: Path) -> None:
    silent = offenders(outcomes(DEPRIVED, tmp_path, name), "ASKED")
    assert not silent, in_lines(silent)


@pytest.mark.parametrize("name", OPEN)
def test_a_file_that_takes_an_expert_is_not_read_wrongly(name: str, tmp_path: Path) -> None:
    wrong = offenders(outcomes(OPEN_TO_BOTH, tmp_path, name), "RIGHT", "ASKED", "LACKING")
    assert not wrong, in_lines(wrong)


# Of the generator itself.


def test_every_level_of_every_factor_is_there() -> None:
    seen = Counter(level for case in cases() if case.group == DECIDABLE for level in case.choice.items())
    assert min(seen.values()) >= 5, seen
    groups = Counter(case.group for case in cases())
    assert groups[DECIDABLE] >= 150 and groups[DEPRIVED] >= 150


def test_a_refusal_for_another_reason_is_told_from_a_question(tmp_path: Path) -> None:
    assert ASKED.keys() == TAKEN.keys()
    file = tmp_path / "lab.csv"
    file.write_text("eps_a [%],q [kip/in],ev [%]\n0,0,0\n1,100,0.1\n2,150,-0.1\n")
    given = file, ["--strain", "engineering"], packing(0.68, tmp_path), tmp_path / "calibration.toml", None
    assert [read(*given, ASKED[name]).verdict for name in ("unknown unit", "no measure of strain")] == ["ASKED", "ASTRAY"]


def test_no_two_files_are_alike() -> None:
    assert len({(case.content, *case.options) for case in cases()}) == len(cases())


PLAIN_STYLES = ("canonical", "name [unit]", "name (unit)", "row of units")
PLAIN = [case for case in cases() if case.group == DECIDABLE and case.choice["style"] in PLAIN_STYLES]


@pytest.mark.parametrize("case", PLAIN, ids=lambda case: f"{case.number}")
def test_an_expectation_is_what_a_plain_reading_gives(case: Case) -> None:
    found = plainly_read(case)
    assert differences(found, case.truth, None) == []
    assert set(case.truth.required) <= set(found["observables"])


def plainly_read(case: Case) -> dict:
    """As `check` would show it, by the file's columns and what the case says of measure and signs."""
    columns = {quantity: values for quantity, values in _columns(case).items() if quantity != "time"}
    _turn(columns, case)
    observables = _from_void_ratio(columns, case)
    stresses = _stresses(columns)
    pressure = _pressure(case, stresses)
    if pressure and "ratio" not in stresses and "deviator_stress" in columns:
        stresses["ratio"] = 1 + columns["deviator_stress"] / pressure
    axial, volumetric = _strains(columns, case)
    if volumetric is not None:
        observables["volumetric_strain"] = volumetric
    if "ratio" in stresses:
        observables["stress_ratio"] = stresses["ratio"]
    if case.truth.kind == "undrained":
        observables |= {"deviatoric_stress": stresses["axial"] - stresses["lateral"], "excess_pore_pressure": stresses["lateral"][0] - stresses["lateral"]}
    control = case.truth.control[0]
    figures = {name: _figures(values) for name, values in observables.items()}
    if axial is not None and case.truth.control_figures:
        figures[control] = _figures(-axial if control == "axial_extension" else axial)
    return {"kind": case.truth.kind, "confining_pressure": pressure, "states": len(next(iter(columns.values()))), "control": control, "observables": figures}


def _figures(values: Array) -> dict[str, float]:
    return {"first": float(values[0]), "last": float(values[-1]), "min": float(values.min()), "max": float(values.max())}


def _columns(case: Case) -> dict[str, Array]:
    """The columns in SI units, rows of the shearing alone."""
    lines = case.content.decode(case.encoding).splitlines()
    split = [_split(line, case.choice["delimiter"]) for line in lines]
    head = next(number for number, cells in enumerate(split) if len(cells) > 1 and not cells[0].startswith("#"))
    names = [re.sub(r"\s*[\[(][^\])]*[\])]$", "", cell) for cell in split[head]]
    in_row = case.choice["style"] == "row of units"
    units = [cell.strip("[]") for cell in split[head + 1]] if in_row else [(re.findall(r"[\[(]([^\])]*)[\])]$", cell) or [""])[0] for cell in split[head]]
    rows = [(number, cells) for number, cells in enumerate(split[head + 1 + in_row :], head + 2 + in_row) if len(cells) == len(names)]
    if names[0] == "Stage":
        rows = [(number, cells) for number, cells in rows if cells[0] in ("3", "Shear")]
    if "--rows" in case.options:
        first, last = map(int, case.options[case.options.index("--rows") + 1].split("-"))
        rows = [(number, cells) for number, cells in rows if first <= number <= last]
    columns = {}
    for place, (name, unit) in enumerate(zip(names, units, strict=True)):
        quantity = next((quantity for words in (CANONICAL, ENGLISH) for quantity, known in words.items() if name in known), None)
        quantity = quantity or {"Vertical strain": "axial_strain"}.get(name) or ("axial_stress" if "ertical" in name else "time" if name == "Time" else None)
        if quantity:
            columns[quantity] = np.array([_number(cells[place], case.choice["decimal"]) for _, cells in rows]) * _factor(
                unit, [cells[place] for _, cells in rows]
            )
    return columns


def _split(line: str, delimiter: str) -> list[str]:
    if delimiter == "spaces":
        return re.split(r"\s{2,}", line.strip())
    return next(csv.reader([line], delimiter={"comma": ",", "semicolon": ";", "tab": "\t"}[delimiter]), [])


def _number(cell: str, decimal: str) -> float:
    cell = cell.strip("%")
    return float(cell.replace(",", "") if decimal == "point" else cell.replace(".", "").replace(",", "."))


def _factor(unit: str, cells: list[str]) -> float:
    if cells[0].endswith("%"):
        return 0.01
    return {**PRESSURES, **FRACTIONS, "": 1.0, "s": 1.0, "‰": 0.001}[unit.replace("²", "2")]


def _turn(columns: dict[str, Array], case: Case) -> None:
    normal = [columns[quantity] for quantity in ("axial_stress", "lateral_stress", "mean_stress") if quantity in columns]
    if normal and normal[0][0] < 0:
        for quantity in columns.keys() - {"void_ratio", "porosity"}:
            columns[quantity] = -columns[quantity]
        if "mean_stress" in columns and "deviator_stress" in columns and case.truth.kind == "triaxial":
            mean, q = columns["mean_stress"], columns["deviator_stress"]
            columns["deviator_stress"] = min([q, -q], key=lambda either: np.ptp(mean - either / 3))
    elif case.choice["sign"] == "dilation positive":
        columns["volumetric_strain"] = -columns["volumetric_strain"]


def _from_void_ratio(columns: dict[str, Array], case: Case) -> dict[str, Array]:
    if "porosity" in columns:
        return {"void_ratio": columns["porosity"] / (1 - columns["porosity"])}
    return {"void_ratio": columns["void_ratio"]} if "void_ratio" in columns else {}


def _stresses(columns: dict[str, Array]) -> dict[str, Array]:
    q, u = columns.get("deviator_stress"), columns.get("pore_pressure", 0.0)
    lateral, axial = columns.get("lateral_stress"), columns.get("axial_stress")
    if "total_lateral_stress" in columns:
        lateral = columns["total_lateral_stress"] - u
    if "total_axial_stress" in columns:
        axial = columns["total_axial_stress"] - u
    if "s" in columns:
        axial, lateral = columns["s"] + columns["t"], columns["s"] - columns["t"]
    if "mean_stress" in columns and q is not None:
        lateral = columns["mean_stress"] - q / 3
    if lateral is not None and axial is None and q is not None:
        axial = lateral + q
    if "stress_ratio" in columns:
        return {"ratio": columns["stress_ratio"]}
    if "deviator_to_mean_stress" in columns:
        eta = columns["deviator_to_mean_stress"]
        return {"ratio": (3 + 2 * eta) / (3 - eta)}
    return {"axial": axial, "lateral": lateral, "ratio": axial / lateral} if axial is not None and lateral is not None else {}


def _strains(columns: dict[str, Array], case: Case) -> tuple[Array | None, Array | None]:
    measured = {quantity: columns[quantity] for quantity in ("axial_strain", "volumetric_strain", "radial_strain") if quantity in columns}
    # From the first row on: the length then is the length of before, less the strain of before.
    if case.choice["measure"] == "engineering":
        measured = {quantity: -np.log(1 - (values - values[0]) / (1 - values[0])) for quantity, values in measured.items()}
    else:
        measured = {quantity: values - values[0] for quantity, values in measured.items()}
    if "radial_strain" in measured:
        measured["volumetric_strain"] = measured["axial_strain"] + 2 * measured["radial_strain"]
    return measured.get("axial_strain"), measured.get("volumetric_strain")


def _pressure(case: Case, stresses: dict[str, Array]) -> float | None:
    if "lateral" in stresses:
        return float(stresses["lateral"][0])
    if "--confining-pressure" in case.options:
        pressure = float(case.options[case.options.index("--confining-pressure") + 1])
    else:
        said = re.search(r"confining pressure\D*(\d+) kPa", case.content.decode(case.encoding))
        pressure = 1e3 * float(said[1]) if said else None
    return pressure
