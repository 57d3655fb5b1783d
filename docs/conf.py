"""The documentation as a site: `make docs`. It is built and read without a network, so nothing is fetched from another site."""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

import graincal

project = "graincal"
author = "the authors of graincal"
version = release = graincal.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "commands", "formulas", "keys"]
exclude_patterns = ["_build", "notebooks/*.ipynb"]
nitpicky = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
# What is quoted is often to be typed.
smartquotes = False
# Pages link to headings of each other as GitHub names them, to the fourth level, so that the links work in the repository too.
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
# A NamedTuple or a dataclass shows its fields where the class describes them.
autodoc_preserve_defaults = True
python_display_short_literal_types = True

html_theme = "furo"
html_title = f"graincal {release}"
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False
# Equations as MathML, which browsers draw by themselves: MathJax comes from another site.
html_math_renderer = "mathml"


def _plain(sphinx, what, name, thing, options, lines: list[str]) -> None:
    """Docstrings are plain text with `code` in single backticks, as Markdown has it; autodoc reads reStructuredText."""
    parts = re.split(r"(?<!`)`([^`]+)`(?!`)", "\n".join(lines).replace("``", "`"))
    said = [re.sub(r"([|*])", r"\\\1", part) if not at % 2 else f"``{' '.join(part.split())}``\\ " for at, part in enumerate(parts)]
    lines[:] = "".join(said).split("\n")


def setup(sphinx) -> None:
    sphinx.connect("autodoc-process-docstring", _plain)
