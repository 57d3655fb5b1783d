"""Pictures of pages by a headless Chromium, for the other programs here."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

COLOURS = 128
"""Of a picture: text and flat areas look the same, and the file is a third of the size."""


def take_page(page: str, size: tuple[int, int], path: Path) -> None:
    """Write a picture of a page, given as HTML, in a window so many pixels wide and high."""
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "page.html"
        file.write_text(page, encoding="utf-8")
        take(file, size, path)


def take(file: Path, size: tuple[int, int], path: Path) -> None:
    """Write a picture of a file of HTML, in a window so many pixels wide and high. Ends the program where there is no Chromium."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        sys.exit("no Chromium is installed to open the page with")
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as profile:
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--allow-file-access-from-files", "--virtual-time-budget=10000"]
        command += [f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}", f"--screenshot={path.resolve()}", file.as_uri()]
        subprocess.run(command, check=True, capture_output=True)
    Image.open(path).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")
