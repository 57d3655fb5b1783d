import shutil
import tempfile
from pathlib import Path

import pytest

from .slurm_one_node import OneNodeSlurm, why_not


@pytest.fixture
def slurm():
    """A real Slurm of one node."""
    if why := why_not():
        pytest.skip(why)
    folder = Path(tempfile.mkdtemp(prefix="slurm"))
    cluster = OneNodeSlurm(folder)
    yield cluster
    cluster.stop()
    shutil.rmtree(folder, ignore_errors=True)
