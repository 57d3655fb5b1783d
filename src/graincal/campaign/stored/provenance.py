"""What a campaign was computed with."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import version

from graincal import build

_LIBRARIES = ("numpy", "scipy", "scikit-learn")


def provenance() -> dict[str, str]:
    """Version, commit, compiler and instruction set of graincal, and the versions of what its figures rest on besides."""
    return build.describe() | {"Python": platform.python_version()} | {library: version(library) for library in _LIBRARIES}


def differences(before: Mapping[str, str], now: Mapping[str, str]) -> str:
    """What differs, as a clause; empty if nothing does."""
    return ", ".join(f"{name} {now.get(name)} instead of {value}" for name, value in before.items() if now.get(name) != value)
