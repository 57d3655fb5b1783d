"""Reading another file as one before it was read: by the same columns where it has them, and by the same conventions."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Any

from graincal.errors import InputError
from graincal.laboratory.addressing import MissingColumn, column_index, listed_columns, refuse_shared
from graincal.laboratory.columns import Conventions, Place
from graincal.laboratory.loading_path import source_of
from graincal.laboratory.quantities import SIGNED, STRAINS, STRESS_FORMS
from graincal.laboratory.reading import Test, read_test, selectable
from graincal.laboratory.table import Table, read_table
from graincal.laboratory.units import split_header
from graincal.positions import POSITION

CARRIED = ("columns", "units", "strain", "compression", "unloading", "zero", "sample_volume", "sample_height", "encoding")
"""Options of `read_test` that hold for other files of a laboratory too. Up to where it is read is of one file alone, and so are those in _OF_ONE_FILE."""
_OF_ONE_FILE = ("sheet", "stage", "rows")


@dataclass(frozen=True)
class Before:
    """How a file was read before: the options of `read_test` that were given, of which those in CARRIED are used, and what that reading is called, as `"drained"`."""

    called: str
    options: Mapping[str, Any]

    @property
    def carried(self) -> dict[str, Any]:
        """The options that hold for another file."""
        return {key: value for key, value in self.options.items() if key in CARRIED}

    @property
    def left(self) -> dict[str, Any]:
        """Options that choose a part of the file, and are of that file alone."""
        return {key: self.options[key] for key in _OF_ONE_FILE if self.options.get(key) is not None}


@dataclass(frozen=True)
class _Choice:
    """A way to read the file. asked: what is said of this file itself; carried: of the one before; called: the latter's name, "" for none; left: options of it that are of its own file alone."""

    asked: Mapping[str, Any]
    carried: Mapping[str, Any] = field(default_factory=dict)
    called: str = ""
    left: Mapping[str, Any] = field(default_factory=dict)

    @property
    def columns(self) -> dict[str, Place]:
        return dict(self.asked.get("columns") or self.carried.get("columns", {}))

    @property
    def units(self) -> dict[str, str]:
        return dict((self.asked if self.asked.get("columns") else self.carried).get("units", {}))


@dataclass(frozen=True)
class _Found:
    """What of the wanted quantities a choice finds in a file: the observables, those that are recorded beside them, and the quantities of the columns that are read."""

    observables: tuple[str, ...]
    recorded: tuple[str, ...]
    read: tuple[str, ...]


@dataclass(frozen=True)
class _Misfit:
    """What a choice misses in a file."""

    wanted: str


def read_another(
    path: str | PathLike[str],
    control: str,
    observables: Sequence[str],
    *,
    asked: Mapping[str, Any],
    before: Before | None = None,
    recorded: Sequence[str] = (),
    **test: Any,
) -> Test:
    """Read a file over `control`, with those of the observables (names), and of those that are `recorded` and not fitted, that it holds.

    asked: `columns`, `units`, `strain`, `compression` (quantity -> word), `sheet`, `stage` and `rows` for this file. With columns, only these are read, by the conventions of the file `before` where nothing
    else is asked. Without, the columns of the file before are read where this one has all of them, or else those with the quantities' own names.
    test: `confining_pressure` and `turns`, as of `read_test`. The notes begin with which columns were read.

    Raises InputError where the file has no such columns, and as `read_test`.
    """
    misfits: list[tuple[_Choice, _Misfit]] = []
    for choice in _choices(path, asked, before):
        table = _table(path, choice)
        found = _find(table, control, observables, recorded, choice, test)
        if isinstance(found, _Found):
            test_read = read_test(path, control, found.observables, recorded=found.recorded, **_options(control, found, choice), **test)
            return replace(test_read, notes=(*_how(table, control, (*observables, *recorded), choice, found, misfits), *test_read.notes))
        misfits.append((choice, found))
    others = "".join(f", nor is {misfit.wanted} of {choice.called}" for choice, misfit in misfits if choice.columns)
    own = next(misfit for choice, misfit in misfits if not choice.columns or asked.get("columns"))
    columns, example = listed_columns(table, range(len(table.header))), "axial_stress" if control == POSITION else control
    raise InputError(
        f"{table.path}: there is no column of {own.wanted}{others}, and --column {example}=COLUMN:UNIT, for each quantity, was expected to say which of these it is: {columns}."
    )


def _choices(path: str | PathLike[str], asked: Mapping[str, Any], before: Before | None) -> list[_Choice]:
    """The ways to read a file, in the order in which they are tried."""
    plain = _Choice(asked)
    if before is None:
        return [plain]
    carried = {key: value for key, value in before.carried.items() if not (asked.get("columns") and key in ("columns", "units"))}
    as_before = _Choice(asked, carried, before.called, before.left)
    if not carried.get("columns"):
        return [as_before]
    # A number is a column of any file, so a name says more.
    return [as_before, plain] if _by_name(_table(path, as_before), carried["columns"]) else [plain, as_before]


def _table(path: str | PathLike[str], choice: _Choice) -> Table:
    said = {"encoding": choice.carried.get("encoding"), "sheet": choice.asked.get("sheet")}
    return read_table(path, **{key: value for key, value in said.items() if value is not None})


def _by_name(table: Table, columns: Mapping[str, Place]) -> bool:
    """Whether all of these columns are named by what stands above them, and not by a number or a letter."""
    names = {name for header, group in zip(table.header, table.groups or [""] * len(table.header)) for name in (header, split_header(header)[0], group)}
    places = [place for said in columns.values() for place in _places(said)]
    return all(isinstance(place, str) and (place in names or not place.isdecimal() and not (len(place) <= 2 and place.isupper())) for place in places)


def _places(said: Place) -> list[str | int]:
    return [said] if isinstance(said, (str, int)) else list(said)


def _find(table: Table, control: str, observables: Sequence[str], recorded: Sequence[str], choice: _Choice, test: Mapping[str, Any]) -> _Found | _Misfit:
    columns, possible = choice.columns, selectable((control, *observables, *recorded))
    if not choice.asked.get("columns"):
        columns = {quantity: said for quantity, said in columns.items() if quantity in possible}
    asked: dict[str, int] = {}
    for quantity, said in columns.items():
        for place in _places(said):
            try:
                asked[quantity] = column_index(table, place, quantity=quantity, second=quantity not in ("axial_strain", "axial_displacement"))
            except MissingColumn:
                if choice.asked.get("columns"):
                    raise
                return _Misfit(f"'{place}' for {quantity}")
    if choice.asked.get("columns"):
        refuse_shared(table, asked)
    conventions = Conventions(columns, choice.units, None, "positive")
    sources = {}
    for name in (control, *observables, *recorded):
        try:
            sources[name] = source_of(table, name, conventions, test.get("confining_pressure"), test.get("turns"))
        except MissingColumn:
            continue
    there = tuple(name for name in observables if name in sources)
    if control not in sources or not there:
        return _Misfit(control if control not in sources else " or ".join(observables))
    return _Found(
        there,
        tuple(name for name in recorded if name in sources),
        tuple(dict.fromkeys(column.quantity for source in sources.values() for column in source.columns)),
    )


def _options(control: str, found: _Found, choice: _Choice) -> dict[str, Any]:
    """The options of `read_test`: what is said of this file as it is, and of what is said of another what is read here."""
    asked, carried, possible = choice.asked, choice.carried, selectable((control, *found.observables, *found.recorded))
    mine = bool(asked.get("columns"))
    options = {key: carried[key] for key in ("unloading", "sample_volume", "sample_height", "encoding") if key in carried}
    options |= {key: asked[key] for key in _OF_ONE_FILE if key in asked}
    options["columns"] = {quantity: said for quantity, said in choice.columns.items() if mine or quantity in possible}
    options["units"] = {quantity: unit for quantity, unit in choice.units.items() if mine or quantity in found.read}
    strain = asked.get("strain") or _each(carried.get("strain"), [name for name in found.read if name in STRAINS])
    options |= {"strain": strain} if strain else {}
    signs = _each(carried.get("compression"), found.read, SIGNED) | dict(asked.get("compression", {}))
    options |= {"compression": signs} if signs else {}
    zero = [name for name in carried.get("zero", ()) if name in found.read and name not in STRESS_FORMS]
    return options | ({"zero": zero} if zero else {})


def _each(said: str | Mapping[str, str] | None, names: Collection[str], of_one_word: Collection[str] = STRAINS) -> dict[str, str]:
    """What is said of each of the names; a single word is said of those in `of_one_word`."""
    if said is None or isinstance(said, str):
        return {name: said for name in names if said and name in of_one_word}
    return {name: word for name, word in said.items() if name in names}


def _how(table: Table, control: str, observables: Sequence[str], choice: _Choice, found: _Found, misfits: Sequence[tuple[_Choice, _Misfit]]) -> list[str]:
    """What to say of how the file was read."""
    options, notes = _options(control, found, choice), []
    columns = [
        f"{quantity} in {' + '.join(table.label(column_index(table, place, quantity=quantity)) for place in _places(said))}"
        for quantity, said in options["columns"].items()
    ]
    conventions = [
        f"{key} = {_written(options[key])}" for key in CARRIED if key in choice.carried and key in options and options[key] and key not in ("columns", "units")
    ]
    own = "the columns with the quantities' own names"
    if choice.asked.get("columns"):
        notes.append(f"read by --column: {', '.join(columns)}.")
        notes += [f"of {choice.called} was taken {', '.join(conventions)}."] if conventions else []
    elif choice.called:
        how = f"the columns of {choice.called}: {', '.join(columns)}" if columns else f"{own}, as {choice.called}"
        notes.append(f"read by {how}{'; with ' + ', '.join(conventions) if conventions else ''}.")
    else:
        missed = [f"those of {other.called} are not all in it: {misfit.wanted} is not" for other, misfit in misfits if other.called]
        notes.append(f"read by {own}{'; ' + missed[0] if missed else ''}.")
    if choice.left and not any(key in choice.asked for key in _OF_ONE_FILE):
        notes.append(
            f"all of it was read: {' and '.join(f'{key} = {_written(value)}' for key, value in choice.left.items())} of {choice.called} is of another file."
        )
    if left := [name for name in observables if name not in (*found.observables, *found.recorded)]:
        notes.append(
            f"it holds no {' and no '.join(left)}, so that {' and '.join(found.observables)} alone {'is' if len(found.observables) == 1 else 'are'} compared."
        )
    return notes


def _written(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_written(each)}' for key, each in value.items())} }}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_written, value))}]"
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"
