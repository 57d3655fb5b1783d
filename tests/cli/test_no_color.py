"""A terminal that asks for no colours is given none."""

import os
import pty
import re
import subprocess
import sys

import pytest


def printed(environment):
    """What --help prints to a pseudo-terminal."""
    ours, theirs = pty.openpty()
    kept = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR", "TERM", "CI")} | {"TERM": "xterm-256color"}
    ran = subprocess.Popen([sys.executable, "-c", "from graincal.cli import main; main(['calibrate', '--help'])"], stdin=theirs, stdout=theirs, stderr=theirs, env=kept | environment)
    os.close(theirs)
    read = b""
    # Its end is an error of reading, on Linux.
    try:
        while piece := os.read(ours, 65536):
            read += piece
    except OSError:
        pass
    os.close(ours)
    assert ran.wait(timeout=60) == 0
    return read.decode()


@pytest.mark.parametrize(("environment", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_no_color_is_honoured(environment, coloured):
    assert bool(re.search("\x1b\\[[0-9;]*3[0-9]m", printed(environment))) == coloured
