"""The console that tables and progress are drawn on, of a terminal or a notebook."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.text import Text

from graincal.notation.printable import printable


class PrintableConsole(Console):
    """A console that shows what texts hold, names and messages of somebody's among them."""

    def render_str(self, text: str, **options: Any) -> Text:
        """A text as rich renders it."""
        return super().render_str(printable(text, None, lines=True), **options)
