"""graincal status --watch, in a terminal and where there is none."""

import os
import pty
import re
import subprocess
import sys
import threading
import time

import pytest
from report import soil

import graincal as gc


def _slow(theta):
    time.sleep(0.03)
    return soil.respond(theta)


def _calibrate(folder):
    gc.calibrate(gc.PythonModel(_slow), soil.reference(), soil.SPACE, method="iterative-bayesian", seed=3, alpha=20, stop=soil.STOP, workers=1, folder=folder)


@pytest.fixture
def running(tmp_path):
    """A campaign that runs for some seconds."""
    folder = tmp_path / "campaign"
    run = threading.Thread(target=_calibrate, args=(folder,), daemon=True)
    run.start()
    deadline = time.monotonic() + 30
    while not (folder / "log.txt").is_file() or "samples to evaluate" not in (folder / "log.txt").read_text():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    yield folder
    run.join()


def _in_terminal(folder, **environment):
    """What the command writes to a terminal."""
    ours, its = pty.openpty()
    command = [sys.executable, "-c", "from graincal.cli import main; main()", "status", str(folder), "--watch"]
    clean = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE")}
    process = subprocess.Popen(command, stdout=its, stderr=its, env={**clean, "TERM": "xterm-256color", "COLUMNS": "100", "LINES": "30", **environment})
    os.close(its)
    written = b""
    # Linux ends a terminal whose other side is closed with an error.
    try:
        while data := os.read(ours, 4096):
            written += data
    except OSError:
        pass
    os.close(ours)
    return process.wait(60), written.decode()


def test_it_is_drawn_again_until_the_campaign_ends(running):
    code, written = _in_terminal(running)
    assert code == 0
    counts = [int(number) for number in re.findall(r"(\d+) evaluations, ", written)]
    assert counts == sorted(counts) and counts[0] < counts[-1]
    assert "stopped by max_iterations" in written
    assert re.search("\x1b\\[[0-9;]*3[0-9]m", written)


def test_no_color_is_respected(tmp_path):
    soil.calibrate(folder=tmp_path / "campaign")
    code, written = _in_terminal(tmp_path / "campaign", NO_COLOR="1")
    assert code == 0 and "finished" in written
    assert not re.search("\x1b\\[[0-9;]*3[0-9]m", written)


def test_without_a_terminal_it_is_printed_when_it_changes(running, call):
    told = call("status", running, "--watch")
    assert told.code == 0
    counts = [int(number) for number in re.findall(r"(\d+) evaluations, ", told.out)]
    assert len(counts) > 1 and counts == sorted(counts)
    assert "\x1b" not in told.out


def test_it_is_not_for_programs(tmp_path, call):
    told = call("status", tmp_path, "--watch", "--json")
    assert told.code == 1 and "one of them was expected" in told.err
