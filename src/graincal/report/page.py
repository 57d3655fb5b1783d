"""The HTML page: sections, tables and plots in one file that asks nothing of a network."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.resources import files

from plotly.offline import get_plotlyjs

from graincal.drawing.figure import Band, Bars, Figure, Mark, Panel, Points
from graincal.drawing.palette import DASHES, Style
from graincal.drawing.with_plotly import describe, describe_square
from graincal.notation.markup import to_html, to_plain
from graincal.notation.printable import printable, printable_json
from graincal.report.tables import Table

# A browser enforces it: whatever the page holds, it loads nothing from anywhere.
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:"

_MANY = 8
"""Columns, beyond which a table stands closer."""


class Page:
    """A page that grows from top to bottom."""

    def __init__(self, title: str, subtitle: str) -> None:
        self._title = title
        self._body = [f"<header><h1>{to_html(title)}</h1><p>{to_html(subtitle)}</p></header>"]
        self._plots: dict[str, dict] = {}

    def heading(self, text: str) -> None:
        """The heading of a section."""
        self._body.append(f"<h2>{to_html(text)}</h2>")

    @contextmanager
    def folded(self, heading: str, sentence: str = "", level: int = 2) -> Iterator[None]:
        """What is added meanwhile stands folded behind a heading of a level, 2 for a section, and a sentence on it."""
        said = f" <span>{to_html(sentence)}</span>" if sentence else ""
        self._body.append(f"<details><summary><h{level}>{to_html(heading)}</h{level}>{said}</summary>")
        yield
        self._body.append("</details>")

    @contextmanager
    def group(self, kind: str) -> Iterator[None]:
        """What is added meanwhile stands together, as page.css arranges a kind."""
        self._body.append(f'<div class="{kind}">')
        yield
        self._body.append("</div>")

    def paragraph(self, sentences: Iterable[str], kind: str = "") -> None:
        """Sentences, if there are any; kind: "note" for what is said in passing."""
        if text := " ".join(map(to_html, sentences)):
            self._body.append(f'<p class="{kind}">{text}</p>' if kind else f"<p>{text}</p>")

    def items(self, items: Iterable[tuple[str, Iterable[str]]]) -> None:
        """Terms, and the paragraphs that are said of each."""
        rows = "".join(f"<div><dt>{to_html(term)}</dt><dd>{''.join(f'<p>{to_html(text)}</p>' for text in said)}</dd></div>" for term, said in items)
        self._body.append(f"<dl>{rows}</dl>")

    def subheading(self, text: str) -> None:
        """The heading of a part of a section."""
        self._body.append(f"<h3>{to_html(text)}</h3>")

    def notes(self, texts: Iterable[str]) -> None:
        """A list, if there is anything to list."""
        if items := "".join(f"<li>{to_html(text)}</li>" for text in texts):
            self._body.append(f"<ul>{items}</ul>")

    def command(self, line: str) -> None:
        """A command line to copy, which breaks between its options where it is longer than the page is wide."""
        options = " ".join(f"<span>{html.escape(each)}</span>" for each in re.split(" (?=-)", printable(line, None)))
        self._body.append(f"<pre><code>{options}</code></pre>")

    def lines(self, text: str) -> None:
        """Lines of a file to copy, which scroll in a box of their own, and are left out on paper."""
        self._body.append(f'<pre class="lines" tabindex="0"><code>{html.escape(printable(text, None, lines=True))}</code></pre>')

    def table(self, table: Table) -> None:
        """A table, which scrolls inside itself where it is wider than the page."""
        head = "".join(f"<th{_figures(table, k)}>{to_html(text)}</th>" for k, text in enumerate(table.head))
        rows = "".join("<tr>" + "".join(f"<td{_figures(table, k)}>{to_html(text)}</td>" for k, text in enumerate(row)) + "</tr>" for row in table.rows)
        thead = f"<thead><tr>{head}</tr></thead>" if any(table.head) else ""
        wide = ' class="wide"' if len(table.head) > _MANY else ""
        self._body.append(f'<div class="scrolls" tabindex="0"><table{wide}>{thead}<tbody>{rows}</tbody></table></div>')

    def figure(self, figure: Figure, *, leads: bool = False) -> None:
        """A figure with its title, key and caption. leads: it stands on the first screen, with its caption folded."""
        level = 2 if leads else 3
        plots = (
            self._square(figure)
            if figure.square
            else "".join(self._panel(figure, k, _unit_alone(panel) if leads else panel, level + 1) for k, panel in enumerate(figure.panels))
        )
        # Those of two tests stand in one row on a wide first screen, so that the answer is on it too.
        columns = 4 if leads and len(figure.panels) == 4 else figure.columns
        frames = f'<div class="{"scrolls" if figure.square else "panels"}" style="--columns:{columns}">{plots}</div>'
        key = "".join(f"<li>{_swatch(mark)}<span>{to_html(mark.name)}</span></li>" for mark in figure.key)
        caption = f"<figcaption>{to_html(figure.caption)}</figcaption>"
        if leads:
            caption = f"<details><summary>What is drawn</summary>{caption.replace('figcaption>', 'p>')}</details>"
        parts = [f"<h{level}>{to_html(figure.title)}</h{level}>", f'<ul class="key">{key}</ul>' if key else "", frames, caption]
        kind = ' class="leads"' if leads else ""
        self._body.append(f'<figure id="{figure.name}"{kind}>{"".join(parts)}</figure>')

    def parts(self) -> tuple[str, dict[str, dict]]:
        """What stands on the page as HTML, without its head, and the descriptions of its plots by the ids of their frames: for a page that is not one file."""
        return "\n".join(self._body[1:]), self._plots

    def render(self) -> str:
        """The whole page."""
        assets = files("graincal.report")
        # No text in it may end the script, or hide what follows.
        plots = printable_json(self._plots, separators=(",", ":")).replace("<", "\\u003c")
        return "\n".join(
            [
                '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
                f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
                '<meta name="viewport" content="width=device-width, initial-scale=1">',
                f'<link rel="icon" href="data:,">\n<title>{html.escape(printable(to_plain(self._title), None))}</title>',
                f"<style>\n{(assets / 'page.css').read_text(encoding='utf-8')}</style>\n</head>\n<body>\n<main>",
                *self._body,
                "<noscript><p>The figures are drawn by a script in this file, and scripts are switched off.</p></noscript>",
                f'</main>\n<script type="application/json" id="plots">{plots}</script>',
                f"<script>{get_plotlyjs()}</script>",
                f"<script>\n{(assets / 'page.js').read_text(encoding='utf-8')}</script>\n</body>\n</html>\n",
            ]
        )

    def _panel(self, figure: Figure, number: int, panel: Panel, level: int) -> str:
        plot = f"plot-{figure.name}-{number}"
        self._plots[plot] = describe(panel)
        title = f"<h{level}>{to_html(panel.title)}</h{level}>" if panel.title else ""
        return f'<div class="panel">{title}{_frame(plot, panel.title or figure.title)}</div>'

    def _square(self, figure: Figure) -> str:
        plot = f"plot-{figure.name}"
        self._plots[plot] = describe_square(figure)
        return _frame(plot, figure.title)


def _unit_alone(panel: Panel) -> Panel:
    """The panel with the unit alone beside its upright axis, which is short on the first screen: its title has the name."""
    name, bracket, unit = panel.y.label.rpartition(" [")
    return replace(panel, y=replace(panel.y, label=f"[{unit}")) if bracket and panel.title else panel


def _frame(plot: str, title: str) -> str:
    return f'<div class="plot" id="{plot}" role="img" aria-label="{html.escape(printable(to_plain(title), None))}"></div>'


def _figures(table: Table, column: int) -> str:
    return ' class="n"' if column >= table.figures else ""


def _swatch(mark: Mark) -> str:
    """A mark of the key as a small drawing."""
    return f'<svg width="28" height="14" viewBox="0 0 28 14" aria-hidden="true">{_shape(mark, mark.style)}</svg>'


def _shape(mark: Mark, style: Style) -> str:
    if isinstance(mark, (Band, Bars)):
        return f'<rect x="2" y="2" width="24" height="10" fill="{style.colour}" fill-opacity="{style.opacity}"/>'
    if not isinstance(mark, Points):
        dashes = " ".join(map(str, DASHES[style.dash]))
        return f'<path d="M1 7H27" stroke="{style.colour}" stroke-width="{style.width}" stroke-dasharray="{dashes}"/>'
    r = min(style.size, 11) / 2
    drawn = {
        "circle": f'<circle cx="14" cy="7" r="{r}" fill="{style.colour}"/>',
        "ring": f'<circle cx="14" cy="7" r="{r}" fill="none" stroke="{style.colour}" stroke-width="{style.width}"/>',
        "cross": f'<path d="M{14 - r} {7 - r}L{14 + r} {7 + r}M{14 - r} {7 + r}L{14 + r} {7 - r}" stroke="{style.colour}" stroke-width="{style.width}"/>',
        "diamond": f'<path d="M14 {7 - r}L{14 + r} 7L14 {7 + r}L{14 - r} 7Z" fill="{style.colour}"/>',
        "square": f'<rect x="{14 - r}" y="{7 - r}" width="{2 * r}" height="{2 * r}" fill="{style.colour}"/>',
    }
    return drawn[style.symbol]
