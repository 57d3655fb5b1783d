"""Which column of a table is meant: by its header, by its group, by its number, or by its letter as in a spreadsheet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from graincal.errors import InputError
from graincal.laboratory.table import Table
from graincal.laboratory.units import split_header
from graincal.suggestion import did_you_mean


class MissingColumn(InputError):
    """A column that is meant is not in the file."""


def column_index(table: Table, said: int | str, *, second: bool = False, quantity: str = "") -> int:
    """The index, from 0, of the column that is meant.

    `said` is a number from 1, or a text: an exact header; a header without its unit in brackets; for columns in groups "GROUP: NAME", "GROUP NAME" or the
    group alone, which means its first column, and with `second` its other one; a number in digits; a letter A to ZZ where no header is that.
    `quantity` is what it is read as, for messages. Raises InputError for a column that is not there, and for what several columns answer to.
    """
    if isinstance(said, bool) or not isinstance(said, (int, str)):
        raise InputError(f"{table.path}: a column is named by its header or its number, and not by {said!r}.")
    if isinstance(said, int):
        return _numbered(table, said, str(said))
    wanted, purpose = " ".join(said.split()), f" for {quantity}" if quantity else ""
    for names in (table.header, [split_header(header)[0] for header in table.header], *_grouped(table)):
        found = [index for index, name in enumerate(names) if name and name == wanted]
        if len(found) == 1:
            return found[0]
        if found:
            raise InputError(
                f"{table.path}: {len(found)} columns answer to '{wanted}'{purpose} ({listed_columns(table, found)}), and a single one was expected (a column may be named by its number)."
            )
    if wanted and wanted in table.groups:
        return _of_group(table, wanted, second)
    if wanted.isascii() and wanted.isdecimal() and len(wanted) < 10:
        return _numbered(table, int(wanted), wanted)
    if 1 <= len(wanted) <= 2 and wanted.isascii() and wanted.isalpha() and wanted.isupper() and (number := _letters(wanted)) <= len(table.header):
        return number - 1
    raise missing_column(table, f"'{said}'{purpose}", said)


def refuse_shared(table: Table, asked: Mapping[str, int]) -> None:
    """Refuse a column, by its index, that a person names for two quantities."""
    for quantity, index in asked.items():
        if other := next((name for name, at in asked.items() if at == index and name != quantity), None):
            raise InputError(f"{table.path}: column {table.label(index)} is named for {quantity} and for {other}, and another column for each was expected.")


def missing_column(table: Table, wanted: str, name: str) -> MissingColumn:
    """That there is no column of that name, which is said as `wanted`; where no column has a name, why."""
    if not any(table.header):
        asked = next((question.sentence for question in table.questions if question.key == "columns"), "No column has a name.")
        why = asked[:1].lower() + asked[1:].rstrip(".")
        return MissingColumn(f"{table.path}: there is no column {wanted}, for {why}.")
    meant = did_you_mean(split_header(name)[0], [split_header(header)[0] for header in table.header])
    present = ", ".join(f"'{header}'" for header in table.header if header)
    return MissingColumn(
        f"{table.path}: there is no column {wanted}{meant}, and those present are {present} (columns = {{ ... }} in a calibration file says which is which)."
    )


def _grouped(table: Table) -> list[list[str]]:
    if not table.groups:
        return []
    pairs = list(zip(table.groups, table.header, strict=True))
    bare = [(group, split_header(header)[0]) for group, header in pairs]
    return [[f"{group}{between}{header}" if group else "" for group, header in names] for names in (pairs, bare) for between in (": ", " ")]


def _of_group(table: Table, group: str, second: bool) -> int:
    found = [index for index, name in enumerate(table.groups) if name == group]
    if len(found) != 2:
        raise InputError(
            f"{table.path}: the group '{group}' has {len(found)} column{'s' if len(found) > 1 else ''} ({listed_columns(table, found)}),"
            " and a pair was expected where a group stands for its columns."
        )
    return found[second]


def _numbered(table: Table, number: int, said: str) -> int:
    if not 1 <= number <= len(table.header):
        raise MissingColumn(
            f"{table.path}: there is no column {said}, and a number from 1 to {len(table.header)} was expected ({listed_columns(table, range(len(table.header)))})."
        )
    return number - 1


def _letters(text: str) -> int:
    number = 0
    for letter in text:
        number = 26 * number + ord(letter) - ord("A") + 1
    return number


def listed_columns(table: Table, indices: Sequence[int]) -> str:
    """Columns with their numbers, to choose from: `1 'eps1', 2 without a name`."""
    words = [f"{index + 1} {table.label(index) if table.header[index] else 'without a name'}" for index in indices]
    return ", ".join(words[:12]) + (" and more" if len(words) > 12 else "")
