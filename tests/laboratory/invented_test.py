"""An invented drained triaxial test of a dense sand, and one laboratory file per shape that such a test comes in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from graincal.data import Reference

CONFINING_PRESSURE = 2e5
AXIAL_STRAIN = np.linspace(0.0, 0.2, 26)
"""Logarithmic, as all strains here are."""
VOLUMETRIC_STRAIN = 0.30 * AXIAL_STRAIN * np.exp(-AXIAL_STRAIN / 0.01) - 0.06 * (1 - np.exp(-((AXIAL_STRAIN / 0.12) ** 2)))
STRESS_RATIO = 1 + 2.2 * AXIAL_STRAIN / (AXIAL_STRAIN + 0.006) + 1.1 * (AXIAL_STRAIN / 0.05) * np.exp(1 - AXIAL_STRAIN / 0.05)
DEVIATOR_STRESS = (STRESS_RATIO - 1) * CONFINING_PRESSURE
ENGINEERING_AXIAL = 1 - np.exp(-AXIAL_STRAIN)
ENGINEERING_VOLUMETRIC = 1 - np.exp(-VOLUMETRIC_STRAIN)

CANONICAL = "axial_strain [%],volumetric_strain [%],stress_ratio [-]"


@dataclass(frozen=True)
class Shape:
    """A file's text, how it is encoded, what `Reference.read` must be told, and rows that go lost to gaps."""

    name: str
    text: str
    options: Mapping[str, Any] = field(default_factory=dict)
    encoding: str = "utf-8"
    lost: tuple[int, ...] = ()


def rows(*columns: np.ndarray, delimiter: str = ",", decimals: tuple[int, ...] | None = None, decimal: str = ".") -> list[str]:
    """Lines of numbers; of three columns the last is a stress ratio and needs fewer decimals."""
    decimals = decimals or ((5, 5, 4) if len(columns) == 3 else (5,) * len(columns))
    lines = zip(*([f"{value:.{places}f}" for value in column] for column, places in zip(columns, decimals, strict=True)), strict=True)
    return [delimiter.join(cell.replace(".", decimal) for cell in line) for line in lines]


def percent(**how: Any) -> list[str]:
    """Lines of axial strain, volumetric strain (both logarithmic, percent, compression positive) and stress ratio."""
    return rows(100 * AXIAL_STRAIN, 100 * VOLUMETRIC_STRAIN, STRESS_RATIO, **how)


def text(*lines: str, end: str = "\n") -> str:
    return end.join(lines) + end


def with_loop(lines: list[str]) -> list[str]:
    """Unloading and reloading after the 11th state, at 8 % axial strain."""
    return lines[:11] + ["7.9,-1.6,2.5", "7.8,-1.65,1.6", "7.95,-1.6,3.1"] + lines[11:]


def columns(axial_strain: str, volumetric_strain: str, stress_ratio: str, **options: Any) -> dict[str, Any]:
    """The options that say which column is which."""
    return {"columns": {"axial_strain": axial_strain, "volumetric_strain": volumetric_strain, "stress_ratio": stress_ratio}, **options}


def with_gaps(lines: list[str]) -> list[str]:
    """An empty cell in the 4th, the 5th and the 21st state."""
    cells = [line.split(",") for line in lines]
    cells[3][0] = cells[4][1] = cells[20][2] = ""
    return [",".join(row) for row in cells]


REMARK = "# cell pressure 200 kPa"
AT_PRESSURE = {"confining_pressure": CONFINING_PRESSURE}
STRAINS = (100 * AXIAL_STRAIN, 100 * VOLUMETRIC_STRAIN)
ENGINEERING_STRAINS = (100 * ENGINEERING_AXIAL, 100 * ENGINEERING_VOLUMETRIC)
TO_MEAN_STRESS = 3 * (STRESS_RATIO - 1) / (STRESS_RATIO + 2)
WITH_Q = CANONICAL.replace("stress_ratio [-]", "deviator_stress [kPa]")
SEMICOLONS, TABS = CANONICAL.replace(",", ";"), CANONICAL.replace(",", "\t")

SHAPES = (
    Shape("canonical", text(CANONICAL, *percent())),
    Shape(
        "fractions",
        text("axial_strain,volumetric_strain,stress_ratio", *rows(AXIAL_STRAIN, VOLUMETRIC_STRAIN, STRESS_RATIO, decimals=(7, 7, 4))),
    ),
    Shape("engineering strain", text(CANONICAL, *rows(*ENGINEERING_STRAINS, STRESS_RATIO)), {"strain": "engineering"}),
    Shape(
        "engineering strain of length alone",
        text(CANONICAL, *rows(ENGINEERING_STRAINS[0], STRAINS[1], STRESS_RATIO)),
        {"strain": {"axial_strain": "engineering"}},
    ),
    Shape("tension positive", text(CANONICAL, *rows(-STRAINS[0], -STRAINS[1], STRESS_RATIO)), {"compression": "negative"}),
    Shape(
        "dilation positive",
        text(CANONICAL, *rows(STRAINS[0], -STRAINS[1], STRESS_RATIO)),
        {"compression": {"volumetric_strain": "negative"}},
    ),
    Shape(
        "engineering, tension positive, q",
        text(REMARK, WITH_Q, *rows(-ENGINEERING_STRAINS[0], -ENGINEERING_STRAINS[1], -DEVIATOR_STRESS / 1e3)),
        {"strain": "engineering", "compression": "negative", **AT_PRESSURE},
    ),
    Shape("deviator stress in kPa", text(REMARK, WITH_Q, *rows(*STRAINS, DEVIATOR_STRESS / 1e3)), AT_PRESSURE),
    Shape(
        "axial stress in MPa, named so",
        text(REMARK, "Ea(%),Ev(%),sigma1 (MPa)", *rows(*STRAINS, STRESS_RATIO * CONFINING_PRESSURE / 1e6, decimals=(5, 5, 5))),
        {"columns": {"axial_strain": "Ea(%)", "volumetric_strain": "Ev(%)", "axial_stress": "sigma1"}, **AT_PRESSURE},
    ),
    Shape(
        "deviator over mean stress",
        text("axial_strain [%],volumetric_strain [%],q/p'", *rows(*STRAINS, TO_MEAN_STRESS, decimals=(5, 5, 5))),
        {"columns": {"deviator_to_mean_stress": "q/p'"}},
    ),
    Shape("semicolons", text(SEMICOLONS, *percent(delimiter=";"))),
    Shape("tabs", text(TABS, *percent(delimiter="\t"))),
    Shape("white space", text("axial_strain [%]   volumetric_strain [%]  stress_ratio [-]", *percent(delimiter="   "))),
    Shape(
        "names of two words between white space",
        text("axial strain (%)   vol strain (%)  stress ratio", *percent(delimiter="    ")),
        columns("axial strain", "vol strain", "stress ratio"),
    ),
    Shape("decimal commas between semicolons", text(SEMICOLONS, *percent(delimiter=";", decimal=","))),
    Shape("decimal commas between tabs", text(TABS, *percent(delimiter="\t", decimal=","))),
    Shape("decimal commas between spaces", text(CANONICAL.replace(",", " "), *percent(delimiter=" ", decimal=","))),
    Shape(
        "quoted decimal commas between commas",
        text(CANONICAL, *('"' + line.replace(";", '","') + '"' for line in percent(delimiter=";", decimal=","))),
    ),
    Shape("byte order mark, carriage returns", text(CANONICAL, *percent(), end="\r\n"), encoding="utf-8-sig"),
    Shape("UTF-16, as spreadsheets save Unicode text", text(TABS, *percent(delimiter="\t"), end="\r\n"), encoding="utf-16"),
    Shape("Windows-1252", text("# Versuch für Baugrube, 20 °C", CANONICAL, *percent()), encoding="cp1252"),
    Shape("blank rows", text("", CANONICAL, "", *percent()[:9], "", ",,", "", *percent()[9:], "", "")),
    Shape("comment lines", text("# a test", CANONICAL, "# begins", *percent()[:9], "  # half", *percent()[9:], "# ends")),
    Shape("names in a comment", text("# " + CANONICAL.replace(",", " "), *percent(delimiter=" "))),
    Shape(
        "lines above the header",
        text("Test;CD-12;;", "Date;12.03.2020;;", "Cell pressure (kPa);200;;", ";;;", SEMICOLONS, *percent(delimiter=";")),
    ),
    Shape(
        "a line of units",
        text(REMARK, "stage;eps_a;eps_v;q", ";%;%;kPa", *("shear;" + line for line in rows(*STRAINS, DEVIATOR_STRESS / 1e3, delimiter=";"))),
        {"columns": {"axial_strain": "eps_a", "volumetric_strain": "eps_v", "deviator_stress": "q"}, **AT_PRESSURE},
    ),
    Shape("other names", text("Ea(%),Ev(%),s1/s3", *percent()), columns("Ea(%)", "Ev(%)", "s1/s3")),
    Shape(
        "other names, units said",
        text('"Axial strain, %","Vol. strain, %",σ1/σ3', *percent()),
        columns("Axial strain, %", "Vol. strain, %", "σ1/σ3", units={"axial_strain": "%", "volumetric_strain": "%"}),
    ),
    Shape("names on two lines of one cell", text('"axial_strain\n[%]","volumetric_strain\n[%]",stress_ratio', *percent())),
    Shape("typographic minus", text(CANONICAL, *(line.replace("-", "\u2212") for line in percent()))),
    Shape(
        "further columns, trailing delimiter",
        text("No.," + CANONICAL + ",time,", *(f"{i},{line},12:{i:02d}," for i, line in enumerate(percent()))),
    ),
    Shape("gaps", text(CANONICAL, *with_gaps(percent())), lost=(3, 4, 20)),
    Shape("a footer", text(CANONICAL, *percent(), "end of test")),
    Shape("an unload-reload loop", text(CANONICAL, *with_loop(percent())), {"unloading": "drop"}),
    Shape("a pause", text(CANONICAL, *percent()[:9], percent()[8], percent()[8], *percent()[9:])),
)

# Each file prints strains to 5e-8 (half of the last digit: 5 decimals of a percent), which -ln(1 - e) widens by at most 1/(1 - 0.18) = 1.22;
# and the stress ratio to 5e-5, or the stress it is made of to at most 2.5e-5 of the confining pressure, or q/p to 5e-6 times dR/d(q/p) < 4.5.
STRAIN_TOLERANCE = 6.2e-8
RATIO_TOLERANCE = 5.1e-5


def written(shape: Shape, folder: Path) -> Path:
    path = folder / "lab.csv"
    path.write_bytes(shape.text.encode(shape.encoding))
    return path


def assert_is_the_invented_test(reference: Reference, lost: tuple[int, ...] = ()) -> None:
    kept = np.delete(np.arange(AXIAL_STRAIN.size), lost)
    assert reference.control_name == "axial_strain"
    assert set(reference.names) == {"stress_ratio", "volumetric_strain"}
    np.testing.assert_allclose(reference.control, AXIAL_STRAIN[kept], rtol=0, atol=STRAIN_TOLERANCE)
    np.testing.assert_allclose(reference.observables["volumetric_strain"], VOLUMETRIC_STRAIN[kept], rtol=0, atol=STRAIN_TOLERANCE)
    np.testing.assert_allclose(reference.observables["stress_ratio"], STRESS_RATIO[kept], rtol=0, atol=RATIO_TOLERANCE)
