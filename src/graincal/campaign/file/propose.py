"""A calibration file for a laboratory file: what it proves is written, what it does not prove is a question."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.file.own_simulator import PARAMETERS as OWN_PARAMETERS
from graincal.campaign.file.own_simulator import PRESSURE_QUESTION, RUN_TIME, OwnSimulator, needs_pressure, stresses
from graincal.data import LONGEST_NAME, InputError, ParameterSpace
from graincal.files import is_unicode
from graincal.inference import DEFAULT_METHOD
from graincal.laboratory.backbone import say_lines
from graincal.laboratory.decisions import UNANSWERED
from graincal.laboratory.describe import describe, describe_table, list_columns
from graincal.laboratory.quantities import DIMENSIONS, STRAINS, STRESS_FORMS, VOID_RATIOS
from graincal.laboratory.stresses import weights
from graincal.laboratory.table import Table
from graincal.laboratory.understanding import Understanding
from graincal.laboratory.understanding.kinds import KINDS
from graincal.laboratory.understanding.strains import of_void_ratio, void_ratio_of
from graincal.notation.printable import printable, printable_json

VOID_RATIO_ERROR = 0.001
STRAIN_RESOLVED, STRESS_RESOLVED = 1e-4, 1e3
"""What laboratories resolve, about: of strains as fractions, by gauges of height and volume; of stresses in Pa, by load cells and pressure transducers."""

_OF_STRESSES = {"deviatoric_stress": ("deviator_stress",), "excess_pore_pressure": ("pore_pressure", "lateral_stress")}
"""Observables, and the stresses that give them."""
_ERRORS = (
    (("stress_ratio",), "1 % of each stress ratio"),
    (STRAINS, f"1 % of the largest strain, and {100 * STRAIN_RESOLVED:g} % of strain at the least"),
    (tuple(_OF_STRESSES), f"1 % of the largest stress in Pa, and {STRESS_RESOLVED / 1e3:g} kPa at the least"),
    (("void_ratio",), f"{VOID_RATIO_ERROR:g} of the void ratio"),
)
"""Observables, and what is said of their errors."""
_MEANINGS = {
    "deviator_stress": "The stress ratio is computed from q = σ1 - σ3, with the confining pressure.",
    "axial_stress": "The stress ratio is computed from the effective σ1, with the confining pressure.",
    "half_difference_stress": "The stress ratio is computed from t = (σ1 - σ3)/2, with the confining pressure.",
    "deviator_to_mean_stress": "The stress ratio is computed from q/p, in triaxial compression.",
}


@dataclass(frozen=True)
class Preparation:
    """A packing to prepare. grading: a name that is known, or a file.

    void_ratio: another one than the sample's, that stands for it; because: the lines that say why. The void ratio is then not compared, but how much the volume has changed.
    """

    particles: int = 1000
    grading: str = "toyoura"
    void_ratio: float | None = None
    because: tuple[str, ...] = ()
    grading_is_file: bool = False

    def table(self, void_ratio: float | str, folder: str | os.PathLike[str] | None) -> dict[str, Any]:
        """Its keys in a calibration file of the folder."""
        grading = _packing(self.grading, folder) if self.grading_is_file else self.grading
        return {"particles": self.particles, "void_ratio": void_ratio, "grading": grading, "seed": 1}


def propose(
    found: Understanding,
    *,
    packing: str | os.PathLike[str] | None = None,
    folder: str | os.PathLike[str] | None = None,
    space: ParameterSpace | None = None,
    preparation: Preparation = Preparation(),
    simulator: OwnSimulator | None = None,
) -> str:
    """The text of a complete calibration.toml, to be checked and edited.

    `packing` (a packing file) is what the user has, `preparation` what is prepared where there is none; `folder` is where the calibration file will stand (default:
    beside the laboratory file); `space` the parameters (default: those of Hartmann, Cheng, Thornton, 2022). `simulator`: what runs instead of graincal's engine; it has no
    packing, and its parameters are questions.
    What the laboratory file does not decide is a key with the value "?", and a comment above it that asks.
    """
    if packing is None and preparation.void_ratio is not None:
        found = replace(found, observables=tuple("volumetric_strain" if name == "void_ratio" else name for name in found.observables))
    blocks = [
        _introduction([*describe(_by_name(found))]),
        OWN_PARAMETERS if simulator else _parameters(space or ParameterSpace.paper()),
        "\n".join(_experiment(found)),
        simulator.model(found.control, found.observables) if simulator else _model(found, packing, folder, preparation),
        _reference(found, folder, _pressure(found) if simulator else []),
        *_settings(simulator),
    ]
    return "\n\n".join(blocks) + "\n"


def propose_unknown(
    table: Table,
    *,
    packing: str | os.PathLike[str] | None = None,
    folder: str | os.PathLike[str] | None = None,
    space: ParameterSpace | None = None,
    preparation: Preparation = Preparation(),
    simulator: OwnSimulator | None = None,
) -> str:
    """As `propose`, for a file whose columns are not known: they are listed, and which is which is asked."""
    name = Path(table.path).name if folder is None else _relative(table.path, folder)
    shown = replace(table, path=Path(table.path).name)
    void_ratio = UNANSWERED if preparation.void_ratio is None else preparation.void_ratio
    grains = {"packing": _packing(packing, folder)} if packing else preparation.table(void_ratio, folder)
    model = {"kind": UNANSWERED, **grains, "confining_pressure": UNANSWERED}
    said = {
        "kind": [f"# Which kind of test is it? triaxial is drained. One of: {', '.join(map(_quote, KINDS))}."],
        "void_ratio": [f"# {line}" for line in preparation.because or ("What is the void ratio before shearing?",)],
        "confining_pressure": ["# What is the confining pressure, as an effective stress in Pa?"],
    }
    blocks = [
        _introduction([*describe_table(shown), "Its columns, by number and name, with their first values:", *(f"  {line}" for line in list_columns(table))]),
        OWN_PARAMETERS if simulator else _parameters(space or ParameterSpace.paper()),
        "\n".join(
            [
                "[[experiment]]",
                f"name        = {_quote(printable(Path(table.path).stem, LONGEST_NAME))}",
                'control     = "axial_strain"',
                "observables = { stress_ratio = { relative_error = 0.01 }, volumetric_strain = { measurement_error = 0.001 } }",
            ]
        ),
        simulator.model("axial_strain", ("stress_ratio", "volumetric_strain")) if simulator else _table("experiment.model", model, said),
        "\n".join(
            [
                "[experiment.reference]",
                f"file        = {_quote(name)}",
                "# Which columns are these: numbers as above, or names? Take out what the file has not.",
                f'columns     = {{ axial_strain = "{UNANSWERED}", deviator_stress = "{UNANSWERED}", volumetric_strain = "{UNANSWERED}" }}',
                '# In which units are they: "%", "-", "kPa", "MPa", "psi" or another?',
                f'units       = {{ axial_strain = "{UNANSWERED}", deviator_stress = "{UNANSWERED}", volumetric_strain = "{UNANSWERED}" }}',
                "# How were strains computed: engineering or logarithmic?",
                f'strain      = "{UNANSWERED}"',
                "# Which sign has compression: positive or negative?",
                f'compression = "{UNANSWERED}"',
                *([PRESSURE_QUESTION, f'confining_pressure = "{UNANSWERED}"'] if simulator else []),
            ]
        ),
        *_settings(simulator),
    ]
    return "\n\n".join(blocks) + "\n"


def _by_name(found: Understanding) -> Understanding:
    """With the file's name in place of its path."""
    return replace(found, table=replace(found.table, path=Path(found.table.path).name))


def _introduction(lines: list[str]) -> str:
    head = [
        'A calibration proposed from a laboratory file. Keys that say "?" are questions: answer each, then run graincal check. Lines that say CHECK rest on what is usual.',
        "",
        "What was understood:",
    ]
    return "\n".join(f"# {printable(line)}".rstrip() for line in [*head, *("  " + line for line in lines)])


def _settings(simulator: OwnSimulator | None) -> list[str]:
    return [
        f'[filter]\n# "iterative-bayesian" is the method of Hartmann, Cheng, Thornton (2022): more runs, and no probabilities.\nmethod = "{DEFAULT_METHOD}"',
        "[stop]\n# It ends where the posterior has settled. A limit of your own ends it sooner; graincal resume goes on with more:\n# max_evaluations = 300",
        '[run]\nworkers = "all"\nseed    = 1' + (f"\n{RUN_TIME}" if simulator else ""),
    ]


def _parameters(space: ParameterSpace) -> str:
    lines = ["[parameters]   # the unknowns and the ranges they are looked for in"]
    for name, low, high, unit in zip(space.names, space.low, space.high, space.units, strict=True):
        unit = f", unit = {_quote(unit)}" if unit else ""
        lines.append(f"{name:6} = {{ range = [{low:g}, {high:g}]{unit} }}")
    return "\n".join(lines)


def _experiment(found: Understanding) -> list[str]:
    errors = ", ".join(f"{name} = {{ {_error(found, name)} }}" for name in found.observables)
    said = [words for names, words in _ERRORS if any(name in names for name in found.observables)]
    return [
        "[[experiment]]",
        f"name        = {_quote(printable(Path(found.table.path).stem, LONGEST_NAME))}",
        f"control     = {_quote(found.control)}",
        f"# CHECK the errors of the measurement, as standard deviations: {'; '.join(said)}. Intervals of the parameters are about in proportion to them.",
        "# Add step = ... (of the display, or to which a curve was read from paper).",
        f"observables = {{ {errors} }}",
    ]


def _error(found: Understanding, name: str) -> str:
    """An error of 1 %, to be corrected: of each value, or where an observable crosses zero of the largest, and then not below what laboratories resolve."""
    if name in ("stress_ratio", "void_ratio"):
        return "relative_error = 0.01" if name == "stress_ratio" else f"measurement_error = {VOID_RATIO_ERROR:g}"
    smallest = STRAIN_RESOLVED if name in STRAINS else STRESS_RESOLVED
    error = np.format_float_positional(float(f"{max(0.01 * _peak(found, name), smallest):.1g}"), trim="-")
    return f"measurement_error = {error}"


def _peak(found: Understanding, name: str) -> float:
    """The largest value of an observable, about, as a fraction or in Pa; 0 where it follows from no column that is read."""
    values = _stress_like(found, name) if name in _OF_STRESSES else _values(found, name)
    if values is None and name == "volumetric_strain" and found.sample_volume and (change := _values(found, "volume_change")) is not None:
        values = change / found.sample_volume
    if (
        values is None
        and name == "volumetric_strain"
        and (ratio := next((column for column in found.seen if column.place in (found.columns.get(each) for each in VOID_RATIOS)), None))
    ):
        known = void_ratio_of(ratio.quantity, ratio.values[~np.isnan(ratio.values)])
        values = None if known is None else of_void_ratio(known, "logarithmic")
    values = np.empty(0) if values is None else values[~np.isnan(values)]
    return float(np.max(np.abs(values))) if values.size else 0.0


def _stress_like(found: Understanding, name: str) -> NDArray[np.float64] | None:
    """The deviator stress or the excess pore pressure (T,) in Pa, about, from whichever columns of stresses are read; None where they do not give it."""
    if (own := _values(found, name)) is not None:
        return own
    read = {stress: values for stress in STRESS_FORMS if stress in found.columns and (values := _values(found, stress)) is not None}
    forms, columns = [STRESS_FORMS[stress] for stress in read], list(read.values())
    # A pore pressure that no column has is what the effective lateral stress loses.
    for wanted in _OF_STRESSES[name]:
        if forms and (by := weights(STRESS_FORMS[wanted], forms)) is not None:
            values = by @ np.stack(columns)
            known = values[~np.isnan(values)]
            return values - known[0] if name == "excess_pore_pressure" and known.size else values
    return None


def _values(found: Understanding, quantity: str) -> NDArray[np.float64] | None:
    """The values (T,) of a quantity that is read from columns of its own, as fractions or in Pa; of several columns their sum."""
    place = found.columns.get(quantity)
    columns = [column for column in found.seen if place is not None and column.place in (place if isinstance(place, list) else [place])]
    return np.sum([column.plain for column in columns], axis=0) if columns else None


def _asks(found: Understanding, *keys: str) -> list[str]:
    """The questions under keys, as comments. Those of one among several keys on a line begin with it."""
    return [
        f"# {_key_on_line(question.key)}{printable(question.sentence)}"
        + (f" One of: {', '.join(map(_quote, question.answers))}." if question.answers else "")
        + (f" Likely: {_quote(question.proposed)}." if question.proposed else "")
        for question in found.questions
        if question.key in keys or question.key.split(".")[0] in keys
    ]


def _key_on_line(key: str) -> str:
    _, _, quantity = key.partition(".")
    return f"{quantity}: " if quantity in DIMENSIONS else ""


def _model(found: Understanding, packing: str | os.PathLike[str] | None, folder: str | os.PathLike[str] | None, preparation: Preparation) -> str:
    """The table of the model, with its packing: each key with what is asked or said of it above."""
    remarks, grains = ({}, {"packing": _packing(packing, folder)}) if packing is not None else _grains(found, folder, preparation)
    asked = {question.key for question in found.questions}
    keys: dict[str, Any] = {"kind": found.kind, **grains, "confining_pressure": UNANSWERED if "confining_pressure" in asked else found.confining_pressure}
    if found.turns:
        keys["turns"] = list(found.turns)
    if "confining_pressure" not in asked:
        remarks["confining_pressure"] = ["# In Pa: " + ("as you gave it." if found.known.confining_pressure else "as the file says.")]
    return _table("experiment.model", keys, {key: [*_asks(found, key), *remarks.get(key, ())] for key in keys})


def _pressure(found: Understanding) -> list[str]:
    """The confining pressure in the reference's table, for a stress ratio that is computed with it; no lines where none is."""
    if not any(question.key == "confining_pressure" for question in found.questions):
        return [f"confining_pressure = {found.confining_pressure:.8g}"] if found.confining_pressure and needs_pressure(found) else []
    return [*_asks(found, "confining_pressure"), f"confining_pressure = {_quote(UNANSWERED)}"]


def _grains(found: Understanding, folder: str | os.PathLike[str] | None, preparation: Preparation) -> tuple[dict[str, list[str]], dict[str, Any]]:
    """A packing to prepare: what is said of its keys, and the keys."""
    asked = any(question.key == "void_ratio" for question in found.questions)
    said = ("as you gave it" if found.known.void_ratio else "as the file says",) if found.void_ratio and not asked else ()
    void_ratio = preparation.void_ratio or (UNANSWERED if asked or not found.void_ratio else found.void_ratio)
    grading = "as you gave it." if preparation.grading != Preparation.grading else "CHECK, that of Toyoura sand unless you give another."
    remarks = {
        "particles": ["# More are closer to the sand and cost in proportion."],
        "void_ratio": [f"# {line}" for line in preparation.because or (f"Before shearing: {each}." for each in said)],
        "grading": [f"# The grading: {grading}"],
    }
    return remarks, preparation.table(void_ratio, folder)


def _table(name: str, keys: Mapping[str, Any], said: Mapping[str, list[str]]) -> str:
    """A table with one key a line, below its comments."""
    width = max(map(len, keys))
    return "\n".join([f"[{name}]", *(line for key, value in keys.items() for line in (*said.get(key, ()), f"{key:{width}} = {_value(value)}"))])


def _packing(packing: str | os.PathLike[str], folder: str | os.PathLike[str] | None) -> str:
    return str(packing) if folder is None else _relative(packing, folder)


def _reference(found: Understanding, folder: str | os.PathLike[str] | None, pressure: list[str]) -> str:
    """pressure: the lines of the confining pressure, where the model's table does not say it."""
    path, known = Path(found.table.path), found.known
    lines = ["[experiment.reference]", f"file        = {_quote(path.name if folder is None else _relative(path, folder))}"]
    if found.table.sheet and known.sheet is not None:
        lines.append(f"sheet       = {_value(known.sheet)}")
    lines += _asks(found, "encoding")
    if known.encoding is not None or any(question.key == "encoding" for question in found.questions):
        lines.append(f"encoding    = {_quote(known.encoding or UNANSWERED)}")
    if found.stage is not None:
        lines.append(f"stage       = {_quote(found.stage)}")
    if known.rows is not None:
        lines.append(f"rows        = [{known.rows[0]}, {known.rows[1]}]")
    if found.zero:
        lines += ["# Strains count from the first row that is read.", f"zero        = {_value(list(found.zero))}"]
    if found.control != "position":
        lines += [f"# {_MEANINGS[name]}" for name in found.columns if name in _MEANINGS and "stress_ratio" in found.observables and len(stresses(found)) == 1]
    lines.append(f"columns     = {_inline(found.columns)}")
    lines += [*_asks(found, "units"), f"units       = {_inline(found.units)}"]
    if found.strain:
        lines += [*_asks(found, "strain"), f"strain      = {_measure(found.strain)}"]
    if found.compression:
        lines += [*_asks(found, "compression"), f"compression = {_inline(found.compression)}"]
    lines += pressure
    for key, size, unit in (("sample_volume", found.sample_volume, "m3"), ("sample_height", found.sample_height, "m")):
        if size:
            lines += [f"# Of the sample when its change is 0, in {unit}, as the file says.", f"{key} = {size:.8g}"]
    if found.loops:
        lines += [f"# The control turns back at {say_lines(found.loops)}: the backbone is kept.", 'unloading   = "drop"']
    if found.control in ("axial_strain", "axial_extension"):
        lines += [
            "# Once a shear band has formed, strains are no longer those of the sample. The last axial strain to compare, as a logarithmic fraction:",
            "# until       = 0.1",
        ]
    return "\n".join(lines)


def _measure(strain: Mapping[str, str]) -> str:
    """One word where all strains have the same measure."""
    words = set(strain.values())
    return _quote(words.pop()) if len(words) == 1 else _inline(strain)


def _relative(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> str:
    """The path as it is written in a file of the folder: an absolute one stays so."""
    name = Path(path) if Path(path).is_absolute() else Path(os.path.relpath(Path(path).absolute(), Path(folder).absolute()))
    if not is_unicode(name):
        raise InputError(f"{name}: this name is not in UTF-8, as all text of a calibration file is, and another name was expected.")
    return name.as_posix()


def _inline(table: Mapping[str, Any]) -> str:
    return "{ " + ", ".join(f"{key} = {_value(value)}" for key, value in table.items()) + " }"


def _value(value: Any) -> str:
    if isinstance(value, str):
        return _quote(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_value, value)) + "]"
    return str(value) if isinstance(value, int) else f"{value:.8g}"


def _quote(text: str) -> str:
    """A TOML basic string: JSON's escapes are among TOML's."""
    return printable_json(text)
