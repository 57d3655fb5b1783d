"""Text with subscripts and superscripts, written `φ_{m}` and `10^{8}`, for the places where text is shown."""

from __future__ import annotations

import html
import re

from graincal.notation.printable import printable

# Letters, digits and signs alone: what else stands in braces is somebody's name.
_SCRIPT = re.compile(r"([_^])\{([\w+−-]*)\}")
_TAGS = {"_": "sub", "^": "sup"}


def to_html(text: str) -> str:
    """As HTML, lines too, everything else escaped; Plotly's labels read it too, and take no dollar for TeX."""
    escaped = html.escape(printable(text, None, lines=True), quote=False).replace("$", "&#36;").replace("\n", "<br>")
    return _SCRIPT.sub(lambda found: f"<{_TAGS[found[1]]}>{found[2]}</{_TAGS[found[1]]}>", escaped)


def to_mathtext(text: str) -> str:
    """As Matplotlib's mathtext."""
    return _SCRIPT.sub(lambda found: rf"${found[1]}{{\mathrm{{{found[2]}}}}}$", printable(text, None, lines=True).replace("$", r"\$"))


def to_plain(text: str) -> str:
    """As plain characters: `φ_m`, `10^8`."""
    return _SCRIPT.sub(r"\1\2", text)
