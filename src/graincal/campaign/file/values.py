"""Kinds of values that keys of a calibration file have."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Count = Annotated[int, Field(ge=1)]


def _only_false(value: Any) -> Any:
    # Zero equals false, and would switch a limit off that was meant to be nothing.
    if value is not False:
        raise ValueError("not false")
    return value


Off = Annotated[Literal[False], BeforeValidator(_only_false)]
Texts = dict[str, str]


def from_root(path: Path) -> Path:
    """The path from the root: what is made of the file is kept and named elsewhere too."""
    return Path(os.path.abspath(path))
