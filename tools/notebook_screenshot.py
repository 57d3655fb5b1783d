"""A picture of a notebook, executed, from its top to so many pixels below, by a headless Chromium.

The folder of a packing is left out, for it is of the machine that the notebook ran on.

    pip install nbconvert ipykernel
    python tools/notebook_screenshot.py docs/notebooks/synthetic_sand.ipynb 1200 docs/images/notebook.png
"""

import re
import sys
from pathlib import Path

import nbformat
from browser_pictures import take_page
from nbclient import NotebookClient
from nbconvert import HTMLExporter

WIDTH = 1000


def main(notebook: Path, height: int, path: Path) -> None:
    """Execute a notebook and write the picture."""
    cells = nbformat.read(notebook, as_version=4)
    NotebookClient(cells, timeout=600, resources={"metadata": {"path": str(notebook.parent)}}).execute()
    page, _ = HTMLExporter(embed_images=True).from_notebook_node(cells)
    page = re.sub(r"[^<> ]*/(?=[^<> /]*\.csv</td>)", "", page)
    take_page(page, (WIDTH, height), path)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(Path(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))
