"""Lines of a calibration file that still say CHECK: what was proposed and nobody has confirmed."""

from __future__ import annotations

import re

from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.file.questions import comment_behind, comments_above

PLACEHOLDER = 1e5
"""Pa: what earlier versions of `graincal init` wrote for a confining pressure that is not known, beside the word CHECK."""

# A sentence that speaks of lines which say CHECK is none of them.
_CHECK = re.compile(r"(?<!say )(?<!says )\bCHECK\b")
_PRESSURE = re.compile(r"\bconfining_pressure\s*=\s*([-+.\deE_]+)")
_OTHERS = re.compile(r"void ratio|grading|particles|packing|density", re.IGNORECASE)


def check_marks(source: str) -> list[Doubt]:
    """What is to be said of the text of a file: a confining pressure that is still the placeholder, and all other lines that say CHECK."""
    lines = source.splitlines()
    said, marked = [], {number for number, line in enumerate(lines, 1) if _CHECK.search(_comment(line))}
    for number, line in enumerate(lines, 1):
        if (marks := _of_placeholder(lines, number, marked)) and _is_placeholder(line):
            text = f"confining_pressure = {PLACEHOLDER:g} on line {number} is what stands for a pressure that is not known: write that of the test, and take the word CHECK out."
            said.append(Doubt("placeholder-pressure", text))
            marked -= marks
    if marked:
        numbers = ", ".join(map(str, sorted(marked)))
        one = len(marked) == 1
        text = f"line{'' if one else 's'} {numbers} say{'s' if one else ''} CHECK: confirm {'it' if one else 'each'} and take the word out."
        said.append(Doubt("check-marks", text))
    return said


def _comment(line: str) -> str:
    return line if line.lstrip().startswith("#") else comment_behind(line)


def _is_placeholder(line: str) -> bool:
    found = None if line.lstrip().startswith("#") else _PRESSURE.search(line)
    try:
        return found is not None and float(found[1]) == PLACEHOLDER
    except ValueError:
        return False


def _of_placeholder(lines: list[str], number: int, marked: set[int]) -> set[int]:
    """The lines that say CHECK of the pressure on a line: itself, or those above it that do not speak of something else alone."""
    above = {at for at, text in comments_above(lines, number) if at in marked and ("pressure" in text.lower() or not _OTHERS.search(text))}
    return above | ({number} & marked)
