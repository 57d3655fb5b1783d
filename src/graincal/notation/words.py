"""Words as sentences need them."""

from __future__ import annotations

from collections.abc import Sequence


def listed(words: Sequence[str]) -> str:
    """One after the other: `φ`, `φ and ν`, `φ, ν and log E`."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def continued(sentence: str) -> str:
    """A sentence as it goes on behind a colon or within another."""
    return sentence[:1].lower() + sentence[1:]
