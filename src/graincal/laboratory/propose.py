"""What was seen of a laboratory file, said in words, and written as a calibration to edit."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from graincal.data import InputError, ParameterSpace
from graincal.inference import DEFAULT_METHOD
from graincal.laboratory.backbone import say_lines
from graincal.laboratory.look import STRESS_NAMES, LaboratoryColumn, LaboratoryFile
from graincal.laboratory.quantities import LARGEST_STRESS_RATIO, STRAINS, STRESS_MEASURES, unsheared
from graincal.laboratory.units import UNITS

_DELIMITER_WORDS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "white space"}
_MEANINGS = {
    "deviator_stress": "q = σ1 - σ3, with the confining pressure above",
    "axial_stress": "the effective σ1, with the confining pressure above",
    "deviator_to_mean_stress": "q/p, in triaxial compression",
}


def describe(file: LaboratoryFile, *, strain: str | None = None, confining_pressure: float | None = None) -> list[str]:
    """What was understood of a file, in lines for a terminal; what the user knows of it besides needs no warning."""
    contradictions = _contradictions(file, strain, confining_pressure)
    file = replace(file, strain_measure=strain or file.strain_measure, confining_pressure=confining_pressure or file.confining_pressure)
    mark = " with a byte order mark" if file.byte_order_mark else ""
    point = "decimal comma" if file.decimal == "," else "decimal point"
    lines = [
        f"{file.path}: {file.rows} rows, columns separated by {_DELIMITER_WORDS[file.delimiter]}, {point}, {file.encoding}{mark}.",
        f"The names of the columns stand on line {file.header_line}. Understood:",
    ]
    used = file.reference
    lines += [f"  {quantity}: {_describe_column(column)}" for quantity, column in used.items()]
    others = [column for column in file.columns if column not in used.values() and column.header]
    if others:
        names = [f"'{column.header}'" + (f" ({said})" if (said := column.quantity or column.unusable) else "") for column in others]
        lines.append(f"Left out: {', '.join(names)}.")
    return lines + contradictions + _warnings(file)


def _contradictions(file: LaboratoryFile, strain: str | None, confining_pressure: float | None) -> list[str]:
    """Where the user says something else than the file."""
    said = []
    if strain and file.strain_measure and strain != file.strain_measure:
        said.append(f"The file speaks of {file.strain_measure} strain, and you of {strain} strain: yours is taken.")
    if confining_pressure and file.confining_pressure and not math.isclose(confining_pressure, file.confining_pressure, rel_tol=0.01):
        said.append(f"The file says a confining pressure of {file.confining_pressure:g} Pa, and you {confining_pressure:g} Pa: yours is taken.")
    return said


def _describe_column(column: LaboratoryColumn) -> str:
    words = [f"column '{column.header}'", f"{column.range[0]:g} to {column.range[1]:g}{'' if column.unit == '-' else ' ' + column.unit}"]
    if column.unit_is_guessed:
        words.append("a plain number to judge by its values" if column.unit == "-" else f"{column.unit} to judge by its values")
    if column.compression == "negative":
        words.append("compression seems negative")
    if column.gaps:
        words.append(f"no number on {say_lines(column.gaps)}")
    return ", ".join(words)


def _warnings(file: LaboratoryFile) -> list[str]:
    """What a person has to know before trusting the columns."""
    strain, stress = file.column("axial_strain"), file.column("stress_ratio")
    warnings = [f"Column '{column.header}', {said}." for column in file.reference.values() for said in column.refused[:3]]
    if not set(STRESS_NAMES) & set(file.reference):
        warnings.append("No column of a stress is understood, so that only the volumetric strain would be compared: a calibration without a stress says little.")
    if said := _doubt_of_stress(file):
        warnings.append(said)
    if file.loops:
        warnings.append(f"The axial strain turns back at {say_lines(file.loops)}: unload-reload loops, of which the backbone is kept.")
    if file.standstills:
        warnings.append(f"The axial strain stands still at {say_lines(file.standstills)}: these rows are dropped.")
    if strain is not None and file.strain_measure is None:
        warnings.append(f"Engineering or logarithmic strain cannot be seen from the numbers: find out which it is.{_difference(strain)}")
    if strain is not None and strain.unit == "%" and not strain.unit_is_guessed and max(map(abs, strain.range)) < 0.5:
        warnings.append(f"'{strain.header}' says %, and its values look like fractions.")
    if stress is not None and stress.range[0] < 0.5:
        warnings.append(f"'{stress.header}' starts near {stress.range[0]:g}, where σ1/σ3 starts at 1: it may be q/p or a stress.")
    if file.confining_pressure is None:
        warnings.append("The file does not say the confining pressure.")
    return warnings


def _doubt_of_stress(file: LaboratoryFile) -> str | None:
    """What is to be said of a stress whose ratio stays at 1, or is beyond that of any soil."""
    name = next((name for name in STRESS_NAMES if name in file.reference), None)
    if name is None:
        return None
    column, measure = file.reference[name], STRESS_MEASURES.get(name)
    ends = np.sort(np.array(column.range) * UNITS[column.unit].factor * (-1.0 if column.compression == "negative" else 1.0))
    at = ""
    if measure is not None and measure.needs_confining_pressure:
        if not file.confining_pressure:
            return None
        at = f" at {file.confining_pressure:g} Pa"
    elif measure is not None and ends[-1] >= 3.0:  # q/p without a lateral stress: refused when it is read
        return None
    low, high = ends if measure is None else measure.ratio(ends, file.confining_pressure)
    if high > LARGEST_STRESS_RATIO:
        return f"'{column.header}'{at}: the stress ratio reaches {high:.3g}, which no soil does: the unit of the stress or the confining pressure is another."
    return f"'{column.header}'{at}: {said}" if (said := unsheared(float(low), float(high))) else None


def _difference(strain: LaboratoryColumn) -> str:
    """What the measure of strain changes, at the largest axial strain; and what is proposed."""
    largest = max(map(abs, strain.range)) * UNITS[strain.unit].factor
    taken = "The proposal says engineering, as most laboratories print"
    return f" {taken}: {100 * largest:.3g} % then means {-100 * math.log1p(-largest):.3g} % logarithmic." if largest < 1 else f" {taken}."


def propose(
    file: LaboratoryFile,
    *,
    strain: str | None = None,
    confining_pressure: float | None = None,
    packing: str | os.PathLike[str] | None = None,
    void_ratio: float | None = None,
    folder: str | os.PathLike[str] | None = None,
    space: ParameterSpace | None = None,
) -> str:
    """The text of a complete calibration.toml, to be checked and edited.

    `strain`, `confining_pressure` (Pa), `packing` (a packing file) and `void_ratio` are what the user knows beyond the file; `folder` is where the calibration file will stand (default:
    beside the laboratory file); `space` the parameters (default: those of Hartmann, Cheng, Thornton, 2022).
    Lines that rest on a guess say CHECK. Raises InputError where the axial strain is not recognised among the headers, or no observable is.
    """
    _refuse_strange(file)
    space = space or ParameterSpace.paper()
    observables = ["stress_ratio" if quantity in STRESS_NAMES else quantity for quantity in file.reference if quantity != "axial_strain"]
    blocks = [
        _introduction(file, strain, confining_pressure),
        _parameters(space),
        "\n".join([*_experiment(file, observables), *_model(file, confining_pressure, _grains(file, void_ratio) if packing is None else _packing(packing, folder))]),
        _reference(file, strain, folder),
        f'[filter]\n# "iterative-bayesian" is the method of Hartmann, Cheng, Thornton (2022): more runs, and no probabilities.\nmethod = "{DEFAULT_METHOD}"',
        "[stop]\n# It ends where the posterior has settled. A limit of your own ends it sooner; graincal resume goes on with more:\n# max_evaluations = 300",
        '[run]\nworkers = "all"\nseed    = 1',
    ]
    return "\n\n".join(blocks) + "\n"


def _refuse_strange(file: LaboratoryFile) -> None:
    found = file.reference
    if "axial_strain" in found and len(found) > 1:
        return
    if reasons := [f"'{column.header}' would be {column.unusable}" for column in file.columns if column.unusable]:
        wanted = "an axial strain and a stress or a volumetric strain"
        raise InputError(f"{file.path}: {wanted} are needed, and not all are there: {'; '.join(reasons)}.")
    lacking = "a stress or a volumetric strain" if "axial_strain" in found else "an axial strain" if found else "an axial strain, a stress or a volumetric strain"
    present = ", ".join(f"'{column.header}'" for column in file.columns if column.header)
    raise InputError(
        f"{file.path}: none of the headers {present} is known as {lacking}, and names such as 'axial_strain [%]', 'volumetric_strain [%]' and "
        "'deviator_stress [kPa]' or 'stress_ratio' were expected."
    )


def _introduction(file: LaboratoryFile, strain: str | None, confining_pressure: float | None) -> str:
    lines = [
        "A calibration proposed from a laboratory file. Lines that say CHECK rest on a guess: confirm or correct each, then run graincal check.",
        "",
        "What was understood:",
        *("  " + line for line in describe(replace(file, path=Path(file.path).name), strain=strain, confining_pressure=confining_pressure)),
    ]
    return "\n".join(f"# {line}".rstrip() for line in lines)


def _parameters(space: ParameterSpace) -> str:
    lines = ["[parameters]   # the unknowns and the ranges they are looked for in"]
    for name, low, high, unit in zip(space.names, space.low, space.high, space.units, strict=True):
        unit = f", unit = {_quote(unit)}" if unit else ""
        lines.append(f"{name:6} = {{ range = [{low:g}, {high:g}]{unit} }}")
    return "\n".join(lines)


def _experiment(file: LaboratoryFile, observables: list[str]) -> list[str]:
    errors = ", ".join(f"{name} = {{ {_error(file, name)} }}" for name in observables)
    return [
        "[[experiment]]",
        f"name        = {_quote(Path(file.path).stem)}",
        'control     = "axial_strain"',
        "# CHECK the errors of the measurement, as standard deviations: 1 % of each value, or of a strain's peak. Intervals of the parameters are about in proportion to them.",
        "# Add step = ... (of the display, or to which a curve was read from paper).",
        f"observables = {{ {errors} }}",
    ]


def _error(file: LaboratoryFile, name: str) -> str:
    """An error of 1 %, to be corrected: of each value, or where an observable crosses zero, of the largest."""
    column = file.reference.get(name)
    peak = 0.0 if column is None else max(map(abs, column.range)) * UNITS[column.unit].factor
    return f"measurement_error = {0.01 * peak:.1g}" if name in STRAINS and peak > 0 else "relative_error = 0.01"


def _model(file: LaboratoryFile, confining_pressure: float | None, grains: tuple[list[str], str]) -> list[str]:
    """The lines of the model: `grains` are remarks and keys of its packing."""
    if confining_pressure:
        pressure = "as you gave it"
    else:
        pressure = "as the file says" if file.confining_pressure else "CHECK, not found in the file, this is only a usual value"
    remarks, keys = grains
    return [
        f"# The confining pressure in Pa: {pressure}.",
        *(f"# {remark}" for remark in remarks),
        f'model       = {{ kind = "triaxial", {keys}, confining_pressure = {confining_pressure or file.confining_pressure or 1e5:.6g} }}',
    ]


def _grains(file: LaboratoryFile, void_ratio: float | None) -> tuple[list[str], str]:
    """A packing to prepare."""
    said = "as you gave it" if void_ratio else "as the file says" if file.void_ratio else "CHECK, that of Toyoura sand in the published tests"
    remarks = [
        f"The void ratio before shearing: {said}. The grading: CHECK, that of Toyoura sand unless you give another.",
        "More particles are closer to the sand and cost in proportion.",
    ]
    return remarks, f'particles = 1000, void_ratio = {void_ratio or file.void_ratio or 0.68:g}, grading = "toyoura", seed = 1'


def _packing(packing: str | os.PathLike[str], folder: str | os.PathLike[str] | None) -> tuple[list[str], str]:
    """A packing that is there."""
    return ["The packing: as you gave it."], f"packing = {_quote(str(packing) if folder is None else _relative(packing, folder))}"


def _reference(file: LaboratoryFile, strain: str | None, folder: str | os.PathLike[str] | None) -> str:
    path = Path(file.path)
    name = path.name if folder is None else _relative(path, folder)
    found = file.reference
    guessed = [quantity for quantity, column in found.items() if column.unit_is_guessed]
    lines = ["[experiment.reference]", f"file        = {_quote(name)}"]
    for measure in set(found) & set(STRESS_MEASURES):
        lines.append(f"# The stress ratio is computed from the {measure.replace('_', ' ')} ({_MEANINGS[measure]}).")
    lines.append(f"columns     = {_inline({quantity: column.header for quantity, column in found.items()})}")
    lines.append(f"# CHECK: the unit of {', '.join(guessed)} is guessed from the values." if guessed else "# As the file says:")
    lines.append(f"units       = {_inline({quantity: column.unit for quantity, column in found.items() if column.unit})}")
    if strain is None and file.strain_measure is None:
        lines.append('# CHECK: cannot be seen from the file; laboratories mostly print "engineering", simulations "logarithmic" strain.')
    lines.append(f"strain      = {_quote(strain or file.strain_measure or 'engineering')}")
    if signs := {quantity: column.compression for quantity, column in found.items() if column.compression}:
        lines.append("# CHECK: guessed from the values, the volumetric strain from its first movement being contraction.")
        lines.append(f"compression = {_inline(signs)}")
    if file.loops:
        lines.append(f"# The axial strain turns back at {say_lines(file.loops)}: the backbone is kept.")
        lines.append('unloading   = "drop"')
    lines.append("# Once a shear band has formed, strains are no longer those of the sample. The last axial strain to compare, as a logarithmic fraction:")
    lines.append("# until       = 0.1")
    return "\n".join(lines)


def _relative(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> str:
    """The path as it is written in a file of the folder: an absolute one stays so."""
    if Path(path).is_absolute():
        return Path(path).as_posix()
    return Path(os.path.relpath(Path(path).absolute(), Path(folder).absolute())).as_posix()


def _inline(table: Mapping[str, str]) -> str:
    return "{ " + ", ".join(f"{key} = {_quote(value)}" for key, value in table.items()) + " }"


def _quote(text: str) -> str:
    """A TOML basic string: JSON's escapes are among TOML's."""
    return json.dumps(text, ensure_ascii=False)
