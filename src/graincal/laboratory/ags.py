"""Files of the AGS format (version 4) for ground investigations: groups of rows, each with headings and units, all in quotation marks."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field

from graincal.errors import InputError
from graincal.laboratory.rows import Row

CURVES = ("CONS",)
"""Groups whose rows are the states of a test. Those of triaxial tests, such as TRIT and TREG, have a row a test, its results."""
SPECIMEN = ("LOCA_ID", "SAMP_TOP", "SAMP_REF", "SAMP_TYPE", "SAMP_ID", "SPEC_REF", "SPEC_DPTH")
"""The headings that tell specimens apart; several tests of one are told apart by nothing else."""


@dataclass
class Group:
    """A group's headings, units and rows. `line` is that of its headings."""

    name: str
    line: int = 0
    headings: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    rows: list[Row] = field(default_factory=list)

    def specimen(self, row: Row) -> str:
        """What the specimen of a row is called: `BH0 3.20 U2`."""
        return " ".join(row.cell(self.headings.index(key)) for key in SPECIMEN if key in self.headings and row.cell(self.headings.index(key)))


def is_ags(text: str) -> bool:
    return text.lstrip().startswith('"GROUP",')


def read_group(text: str, path: str, wanted: str | None) -> tuple[str, Group]:
    """What is to be called the sheet, and a group of one specimen: `wanted` is a group's name, or one and its specimen as `CONS/BH0 3.20 U2`.

    Raises InputError where there is no such group, where none is wanted and not exactly one holds curves, and where a group holds several specimens.
    """
    groups = _groups(text, path)
    full = [name for name, group in groups.items() if group.rows]
    name, _, specimen = (wanted or "").partition("/")
    if wanted is None:
        curves = [each for each in CURVES if each in full]
        if len(curves) != 1:
            raise InputError(
                f"{path}: none of the groups {', '.join(full)} is known to hold the states of a test, as CONS does: say which with --sheet,"
                ' or sheet = "..." in a calibration file.'
            )
        name = curves[0]
    if name not in full:
        raise InputError(f"{path}: there is no group '{name}' with rows, and one of {', '.join(full)} was expected.")
    return _specimen(groups[name], specimen, path)


def _specimen(group: Group, wanted: str, path: str) -> tuple[str, Group]:
    there = list(dict.fromkeys(map(group.specimen, group.rows)))
    chosen = [each for each in there if each == wanted] or [each for each in there if set(wanted.split()) <= set(each.split())]
    if len(chosen) != 1:
        listed = ", ".join(f"'{each}'" for each in (chosen or there))
        if not chosen:
            raise InputError(f"{path}: group {group.name} has no specimen '{wanted}', and one of {listed} was expected.")
        how = f"{group.name}/{chosen[0]}"
        raise InputError(
            f"{path}: group {group.name} holds {len(chosen)} specimens, {listed}: say which with --sheet '{how}', or sheet = \"{how}\" in a calibration file."
        )
    group.rows = [row for row in group.rows if group.specimen(row) == chosen[0]]
    return f"{group.name}/{chosen[0]}" if wanted else group.name, group


def _groups(text: str, path: str) -> dict[str, Group]:
    """The groups by name. A group that is given in parts, with the same headings, is one."""
    groups: dict[str, Group] = {}
    group = Group("")
    reader = csv.reader(text.splitlines(keepends=True))
    line = 1
    for record in reader:
        what, cells = (record[0], tuple(cell.strip() for cell in record[1:])) if record else ("", ())
        if what == "GROUP":
            group = groups.setdefault(cells[0] if cells else "", Group(cells[0] if cells else ""))
        elif what == "HEADING":
            if group.headings and group.headings != cells:
                raise InputError(f"{path}: line {line} gives group {group.name} other headings than line {group.line}, and one set of headings was expected.")
            group.line, group.headings = group.line or line, cells
        elif what == "UNIT":
            group.units = cells
        elif what == "DATA":
            if len(cells) > len(group.headings):
                raise InputError(
                    f"{path}: line {line} has {len(cells)} values where group {group.name} has {len(group.headings)} headings, and one for each was expected."
                )
            group.rows.append(Row(line, cells))
        line = reader.line_num + 1
    return groups
