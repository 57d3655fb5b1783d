"""What is said where something that a user gave cannot be used."""

from __future__ import annotations

import shlex
import sys

from graincal.notation.printable import printable

LONGEST_MESSAGE = 10_000
"""Characters of a message: a list of many columns is long."""


class InputError(ValueError):
    """What a user gave cannot be used. The message is one sentence that names the place and what was expected; whatever it quotes is made printable in it."""

    def __init__(self, message: object = "") -> None:
        super().__init__(printable(message, LONGEST_MESSAGE, lines=True))


def not_installed(what: str, packages: str, extra: str, error: ImportError | None = None) -> InputError:
    """That something needs packages which only an extra of graincal brings, and how that is installed for the Python that runs. error: why they could not be imported, if that was tried."""
    lacks = (error.name or "").partition(".")[0].lower() if isinstance(error, ModuleNotFoundError) else ""
    broken = error is not None and not (lacks and lacks in packages.lower())
    why = f"cannot be imported ({error})" if broken else f"{'are' if ' and ' in packages else 'is'} not installed"
    return InputError(f"{what} needs {packages}, which {why}: {shlex.quote(sys.executable)} -m pip install '.[{extra}]' in the folder of graincal's source.")
