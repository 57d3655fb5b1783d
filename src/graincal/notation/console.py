"""The console that tables and progress are drawn on, of a terminal or a notebook."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.text import Text

from graincal.notation.printable import printable
from graincal.notation.text import between_words


class PrintableConsole(Console):
    """A console that shows what texts hold, names and messages of somebody's among them."""

    def render_str(self, text: str, **options: Any) -> Text:
        """A text as rich renders it."""
        return super().render_str(printable(text, None, lines=True), **options)

    def sentences(self, text: object) -> None:
        """Print lines of prose: in a terminal broken between words, elsewhere as they are."""
        self.print(between_words(str(text), self.width) if self.is_terminal else text, soft_wrap=True)
