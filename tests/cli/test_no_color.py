"""A terminal that asks for no colours is given none."""

import re

import pytest

from .terminal import in_terminal


@pytest.mark.parametrize(("environment", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_no_color_is_honoured(environment, coloured):
    code, printed = in_terminal(["calibrate", "--help"], environment={"TERM": "xterm-256color"} | environment)
    assert code == 0 and bool(re.search("\x1b\\[[0-9;]*3[0-9]m", printed)) == coloured
