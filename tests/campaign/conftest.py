"""What tests of campaigns share."""

import pytest

from graincal.cli import main


class Called:
    """Runs a command in this process: its exit code, and what it printed to `out` and `err`."""

    def __init__(self, capsys, *arguments):
        with pytest.raises(SystemExit) as ended:
            main([str(argument) for argument in arguments])
        self.code = ended.value.code or 0
        self.out, self.err = capsys.readouterr()


@pytest.fixture
def call(capsys):
    return lambda *arguments: Called(capsys, *arguments)
