"""What a misspelt name was probably meant to be."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """` (did you mean "triaxial"?)`, to stand behind a name that is not known; nothing where no known one is like it."""
    # A name in other capitals is like its own.
    spelt = {each.casefold(): each for each in known}
    # One letter is much of a short name; long ones share whole words with names that mean something else.
    close = get_close_matches(str(name).casefold(), spelt, n=1, cutoff=0.6 if len(str(name)) < 5 else 0.75)
    return f' (did you mean "{spelt[close[0]]}"?)' if close else ""
