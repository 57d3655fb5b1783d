"""Small campaigns on a cluster, of a function that waits a little."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

from campaign.hyperbola import write_calibration

from graincal.campaign.found.status import status
from graincal.campaign.stored.store import holds_campaign

SLOW = """

import time


def slowly(theta):
    time.sleep({seconds})
    return respond(theta)
"""

GRAINCAL = "import sys; from graincal.cli import main; main(sys.argv[1:])"

QUICKLY = "import sys; import graincal.execution.parsl as blocks; blocks.HEARTBEATS = (1, 5); import graincal.execution.providers as providers; providers.POLLING = 1; from graincal.cli import main; main(sys.argv[1:])"


def write(folder: Path, run: str = "", seconds: float = 0.4, iterations: int = 2, *replacements: tuple[str, str]) -> Path:
    """A calibration file; run: further lines under [run]."""
    folder.mkdir(parents=True, exist_ok=True)
    file = write_calibration(
        folder,
        ("workers = 1", f'workers = "all"\n{run}'),
        ('"soil:respond"', '"soil:slowly"'),
        ("max_iterations = 3", f"max_iterations = {iterations}"),
        *replacements,
    )
    (folder / "soil.py").write_text((folder / "soil.py").read_text() + SLOW.format(seconds=seconds))
    return file


def start(environment, *arguments, quickly: bool = True) -> subprocess.Popen:
    """graincal with some arguments. quickly: with signs of life and questions to Slurm every second, so that it notices a fault within seconds; otherwise as users have it."""
    return subprocess.Popen(
        [sys.executable, "-c", QUICKLY if quickly else GRAINCAL, *map(str, arguments)],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def call(environment, *arguments, timeout: float = 180) -> str:
    """Run graincal to its end: what it printed."""
    process = start(environment, *arguments)
    try:
        out, err = process.communicate(timeout=timeout)
    finally:
        process.kill()
    assert process.returncode == 0, f"{out}\n{err}"
    return out


def evaluated(folder: Path) -> int:
    return status(folder)["evaluations"] if holds_campaign(folder) else 0


def wait_until(what, seconds: float = 60, why: str = "") -> float:
    """How long it took, s."""
    start = time.monotonic()
    while not what():
        assert time.monotonic() - start < seconds, f"not within {seconds} s: {why or what}"
        time.sleep(0.1)
    return time.monotonic() - start


def log_of(folder: Path) -> str:
    return (folder / "log.txt").read_text()
