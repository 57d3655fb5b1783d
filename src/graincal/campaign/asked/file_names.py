"""Names of experiments as parts of files' names."""

from __future__ import annotations

import hashlib
import re

LONGEST, _DIGEST = 110, 12
"""Bytes of an experiment's name in that of a file, and those of a digest at its end: with what stands before and behind it, less than the 143 that the narrowest file systems take."""


def file_name(experiment: str) -> str:
    """The name of an experiment as part of a file's name: a long one is cut, and then has a digest of the whole name at its end, so that names that differ lead to names that differ."""
    name = re.sub(r"[^\w.-]+", "_", experiment).strip("_.") or "experiment"
    whole = name.encode("utf-8")
    if len(whole) <= LONGEST:
        return name
    return f"{whole[: LONGEST - _DIGEST - 1].decode('utf-8', errors='ignore')}-{hashlib.sha256(experiment.encode('utf-8', errors='surrogatepass')).hexdigest()[:_DIGEST]}"
