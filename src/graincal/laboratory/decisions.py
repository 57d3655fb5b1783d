"""What is decided about a laboratory file, with its proof, and what is asked of the person because nothing in the file decides it."""

from __future__ import annotations

from dataclasses import dataclass

UNANSWERED = "?"
"""The value of a key that a file does not decide."""


@dataclass(frozen=True)
class Decision:
    """A value that the file proves: `what` is the key of a calibration file that it stands under, `because` the proof, as the end of a sentence. by: "proof" for what
    columns prove, "words" for what a line or a name says, "person" for what a person says."""

    what: str
    value: str
    because: str
    by: str = "proof"

    def __str__(self) -> str:
        value = self.value if any(map(str.isalnum, self.value)) else f'"{self.value}"'
        return f"{self.what} = {value}, because {self.because}."


@dataclass(frozen=True)
class Question:
    """What the file does not decide: the `key` that the answer stands under, a sentence, the answers that are possible (empty for any), the one that is likely
    (empty for none), and the option of `graincal init` that answers it."""

    key: str
    sentence: str
    answers: tuple[str, ...] = ()
    proposed: str = ""
    option: str = ""
