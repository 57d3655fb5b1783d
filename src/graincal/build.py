"""What this graincal is: version, commit, compiler, instruction set."""

from __future__ import annotations

import subprocess
from importlib.metadata import version
from pathlib import Path

from graincal import _native

_CHECKOUT = Path(__file__).parents[2]


def commit() -> str:
    """The commit of the Python files at work: of the checkout where they lie in one (with "-dirty" where it was edited), else the one built."""
    if (_CHECKOUT / ".git").exists() and (_CHECKOUT / "native").is_dir():
        try:
            command = ["git", "-C", str(_CHECKOUT), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
            return subprocess.run(command, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            # No git at hand: the commit that was built is the best that is known.
            return _native.commit
    return _native.commit


def describe() -> dict[str, str]:
    """The figures that `graincal --version` prints and every campaign keeps."""
    return {"graincal": version("graincal"), "commit": commit(), "compiler": _native.compiler, "instruction set": _native.instruction_set}
