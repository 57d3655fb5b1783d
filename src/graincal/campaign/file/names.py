"""Names in a calibration file: those that are shown, in messages, tables and figures, and those of files."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator

from graincal.campaign.file.section import mistake, refused, show
from graincal.data import LONGEST_NAME
from graincal.notation.printable import is_printable


def _shown(text: str) -> str:
    if text and not is_printable(text, LONGEST_NAME):
        raise refused(f" must be printable text of at most {LONGEST_NAME} characters, not {show(text)}")
    return text


def _possible(name: str) -> str:
    if "\0" in name:
        raise refused(f" is {show(name)}, and no file can have the character \\u0000 in its name")
    return name


Shown = Annotated[str, AfterValidator(_shown)]
"""Text that stands in messages, tables and figures."""
FileName = Annotated[str, AfterValidator(_possible)]


def with_printable_names(table: dict[str, Any]) -> dict[str, Any]:
    """The table, whose keys are names that are shown. Raises the mistake where one cannot be."""
    if (wrong := next((name for name in table if not is_printable(name, LONGEST_NAME)), None)) is not None:
        raise mistake(f" must have names of printable text, of at most {LONGEST_NAME} characters, not {show(wrong)}")
    return table
