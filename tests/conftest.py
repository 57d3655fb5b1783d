"""What all tests share."""

import os
from pathlib import Path

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


@pytest.fixture(scope="session")
def reference_data():
    """The folder with the published packings and curves, which are not part of the repository."""
    folder = os.environ.get("GRAINCAL_REFERENCE_DATA")
    if not folder:
        pytest.skip("GRAINCAL_REFERENCE_DATA names no folder with the published packings and curves")
    assert Path(folder).is_dir(), f"GRAINCAL_REFERENCE_DATA names {folder}, which is no folder"
    return Path(folder)


@pytest.fixture(scope="module")
def fewer_draws():
    """As many draws from the emulated posterior as facts need that are not about its digits: each batch waits for them."""
    with pytest.MonkeyPatch.context() as patch:
        for name, number in {"PARTICLES": 128, "DRAWS": 256, "EFFECTIVE": 100, "MORE_DRAWS": 256, "SPREAD_DRAWS": 256, "SPREAD_EFFECTIVE": 100}.items():
            patch.setattr(f"graincal.inference.sampling.explore.{name}", number)
        yield
