"""Which cells of an Excel workbook (xlsx) are shown in percent: they hold 0.004 and show 0.40%, below a header that may say %."""

from __future__ import annotations

import io
import posixpath
import re
import zipfile
from collections.abc import Iterator
from xml.etree import ElementTree

BUILT_IN = (9, 10)
"""The numbers of the formats 0% and 0.00%."""
_REFERENCE = re.compile(r"([A-Z]+)(\d+)")
# What stands in quotation marks, or behind a backslash, is text and no percent sign of the format.
_QUOTED = re.compile(r'"[^"]*"|\\.')


def percent_cells(raw: bytes) -> dict[str, set[tuple[int, int]]]:
    """The cells shown in percent, by the names of the sheets: lines from 1 and columns from 0. Nothing for a file that is no xlsx, or says nothing of formats."""
    if not raw.startswith(b"PK"):
        return {}
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as book:
            styles = _percent_styles(book)
            return {name: set(_cells(book, part, styles)) for name, part in _parts(book)} if styles else {}
    except (zipfile.BadZipFile, KeyError, ElementTree.ParseError, ValueError, NotImplementedError, OSError):
        # Whatever is wrong with the workbook is said where its sheets are read.
        return {}


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _percent_styles(book: zipfile.ZipFile) -> set[str]:
    """The numbers of the cell styles that show percent, as cells give them."""
    root = ElementTree.fromstring(book.read("xl/styles.xml"))
    formats = {int(each.attrib["numFmtId"]): _QUOTED.sub("", each.attrib.get("formatCode", "")) for each in root.iter() if _tag(each) == "numFmt"}
    percent = {number for number, code in formats.items() if "%" in code} | {number for number in BUILT_IN if number not in formats}
    styles = next((each for each in root if _tag(each) == "cellXfs"), ())
    return {str(at) for at, style in enumerate(styles) if int(style.attrib.get("numFmtId", 0)) in percent}


def _parts(book: zipfile.ZipFile) -> Iterator[tuple[str, str]]:
    """The names of the sheets and the parts of the file that they stand in."""
    targets = {each.attrib["Id"]: each.attrib["Target"] for each in ElementTree.fromstring(book.read("xl/_rels/workbook.xml.rels"))}
    for sheet in ElementTree.fromstring(book.read("xl/workbook.xml")).iter():
        if _tag(sheet) == "sheet":
            relation = next(value for key, value in sheet.attrib.items() if key.endswith("}id"))
            yield sheet.attrib["name"], posixpath.normpath(posixpath.join("/xl", targets[relation])).lstrip("/")


def _cells(book: zipfile.ZipFile, part: str, styles: set[str]) -> Iterator[tuple[int, int]]:
    if part not in book.namelist():
        return
    with book.open(part) as sheet:
        for _, element in ElementTree.iterparse(sheet):
            if _tag(element) == "c" and element.attrib.get("s") in styles and (place := _REFERENCE.fullmatch(element.attrib.get("r", ""))):
                column = 0
                for letter in place[1]:
                    column = 26 * column + ord(letter) - ord("A") + 1
                yield int(place[2]), column - 1
            elif _tag(element) == "row":
                element.clear()
