"""What was understood of a laboratory file, in lines for a terminal."""

from __future__ import annotations

import numpy as np

from graincal.laboratory.backbone import say_lines, spans
from graincal.laboratory.decisions import Question
from graincal.laboratory.numbers import shown
from graincal.laboratory.table import Table
from graincal.laboratory.understanding import Understanding
from graincal.laboratory.understanding.seen import Seen

_DELIMITER_WORDS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "white space"}


def describe(found: Understanding) -> list[str]:
    """How the file is written, what is read from it, what was decided and by what, and what is asked."""
    read = [(name, column) for name, place in found.columns.items() for column in found.seen if column.place in (place if isinstance(place, list) else [place])]
    lines = [*describe_table(found.table), "Read:", *(f"  {name}: {_column(column, found.table)}" for name, column in read)]
    used = {column.index for _, column in read}
    if others := [column for column in found.seen if column.index not in used and (column.header or column.quantity)]:
        lines.append(f"Left out: {', '.join(_left_out(column) for column in others)}.")
    if found.decided:
        lines += ["Decided:", *(f"  {decision}" for decision in found.decided)]
    if found.loops:
        lines.append(f"The control turns back at {say_lines(found.loops)}: unload-reload loops, of which the backbone is kept.")
    if found.standstills:
        lines.append(f"The control stands still at {say_lines(found.standstills)}: these rows are dropped.")
    lines += [f"Column {column.label}, {said}." for _, column in read for said in column.refused[:3]]
    lines += found.notes
    if "stress_ratio" not in found.observables and "deviatoric_stress" not in found.observables and found.kind not in ("oedometric", "isotropic"):
        lines.append("No column of a stress is understood, so that only the change of volume would be compared: a calibration without a stress says little.")
    if found.questions:
        lines.append('To be answered, in the file where it says "?", or by the option:')
        lines += [f"  {question.key}: {describe_question(question)}" for question in found.questions]
    return lines


def describe_question(question: Question) -> str:
    """The question, the answers that are possible, the one that is likely, and the option that answers it."""
    answers = f" ({', '.join(question.answers)})" if question.answers else ""
    proposed = f" Likely: {question.proposed}." if question.proposed else ""
    return f"{question.sentence}{answers}{proposed}{f' [{question.option}]' if question.option else ''}"


def describe_table(table: Table) -> list[str]:
    """How the file is written."""
    mark = " with a byte order mark" if table.byte_order_mark else ""
    point = "decimal comma" if table.decimal == "," else "decimal point"
    apart = (
        f"columns separated by {_DELIMITER_WORDS[table.delimiter]}, {point}, {table.encoding}{mark}"
        if table.delimiter in _DELIMITER_WORDS
        else "cells of a sheet"
    )
    sheet = f", {shown(table.sheet)}" if table.sheet else ""
    names = f"The names of the columns stand on line {table.header_line}." if table.header_line else "No line names the columns."
    return [f"{table.path}{sheet}: {len(table.rows)} rows, {apart}.", names]


def list_columns(table: Table) -> list[str]:
    """Each column with its number, its name and its first values, for a person who has to say what it is."""
    width = len(table.header)
    lines = []
    for index in range(width):
        values = [row.cell(index) for row in table.rows if row.cell(index)]
        first = ", ".join(map(shown, values[:3])) + (f" ... {shown(values[-1])}" if len(values) > 3 else "")
        name = table.label(index) if table.header[index] else "(no name)"
        lines.append(f"{index + 1}  {name}{f' [{shown(table.units[index])}]' if index < len(table.units) and table.units[index] else ''}: {first}")
    return lines


def _column(column: Seen, table: Table) -> str:
    values = column.values[~np.isnan(column.values)]
    unit = "" if column.unit is None or column.unit.symbol == "-" else f" {column.unit.symbol}"
    words = [f"column {column.label}" if column.header else column.label, f"{values.min():g} to {values.max():g}{unit}"]
    if gaps := spans(np.isnan(column.values), table.lines):
        words.append(f"no number on {say_lines(gaps)}")
    return ", ".join(words)


def _left_out(column: Seen) -> str:
    said = column.unusable or column.quantity
    return f"{column.label}{f' ({said})' if said else ''}"
