"""Pictures of a report's first screen, 1280 and 390 pixels wide, by a headless Chromium.

The folder of a packing is left out, for it is of the machine that the report was written on.

    graincal demo -o demo && python tools/report_screenshots.py demo/report.html docs/images
"""

import re
import sys
import tempfile
from pathlib import Path

from browser_pictures import take

SIZES = ((1280, 800), (390, 844))
"""Of a laptop and of a telephone."""


def main(report: Path, folder: Path) -> None:
    """Write `report_1280.png` and `report_390.png` into a folder."""
    with tempfile.TemporaryDirectory() as scratch:
        shown = Path(scratch) / "report.html"
        shown.write_text(re.sub(r"(?<=--packing )[^ <]*/", "", report.read_text(encoding="utf-8")), encoding="utf-8")
        for width, height in SIZES:
            # In a frame, for a headless window may not be as narrow as a telephone.
            frame = Path(scratch) / "frame.html"
            frame.write_text(
                f'<body style="margin: 0"><iframe src="{shown.as_uri()}" width="{width}" height="{height}" style="border: 0"></iframe>', encoding="utf-8"
            )
            take(frame, (width, height), folder / f"report_{width}.png")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(Path(sys.argv[1]), Path(sys.argv[2]))
