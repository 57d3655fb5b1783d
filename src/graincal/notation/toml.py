"""TOML as calibration files have it: whatever else a text is, it is said in a sentence."""

from __future__ import annotations

import tomllib
from typing import Any

DEEPEST = 20
"""Tables and lists within each other; no key is deeper than ten."""

LARGEST_WHOLE = 2**63 - 1
"""What TOML promises of whole numbers."""


class NotTOML(ValueError):
    """A text is no TOML, or none that a calibration file can be. The message says why, without a full stop."""


def read_toml(text: str) -> dict[str, Any]:
    """What a text says. Raises NotTOML."""
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise NotTOML(str(error)) from None
    except RecursionError:
        raise NotTOML(f"tables or lists within each other are more than {DEEPEST}") from None
    # Of a number of thousands of digits, which Python does not read.
    except ValueError:
        raise NotTOML(f"a number in it has thousands of digits, and whole numbers up to {LARGEST_WHOLE} were expected") from None
    _check(content)
    return content


def _check(content: dict[str, Any]) -> None:
    level: list[Any] = [content]
    for _ in range(DEEPEST + 1):
        if any(isinstance(value, int) and abs(value) > LARGEST_WHOLE for value in level):
            raise NotTOML(f"a number in it has more digits than a whole number may have, and up to {LARGEST_WHOLE} was expected")
        level = [inner for value in level if isinstance(value, (dict, list)) for inner in (value.values() if isinstance(value, dict) else value)]
        if not level:
            return
    raise NotTOML(f"tables or lists within each other are more than {DEEPEST}")
