"""What is said where something that a user gave cannot be used."""

from __future__ import annotations

from graincal.notation.printable import printable

LONGEST_MESSAGE = 10_000
"""Characters of a message: a list of many columns is long."""


class InputError(ValueError):
    """What a user gave cannot be used. The message is one sentence that names the place and what was expected; whatever it quotes is made printable in it."""

    def __init__(self, message: object = "") -> None:
        super().__init__(printable(message, LONGEST_MESSAGE, lines=True))
