"""Letters that a font does not have."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def missing_glyphs_unsaid() -> Iterator[None]:
    """Where figures are drawn: Matplotlib draws a box for a letter that its font does not have, and need not say so for each on standard error."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"Glyph \d+ .*missing from")
        yield
