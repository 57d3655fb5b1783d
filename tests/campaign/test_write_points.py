"""A campaign that is killed where it writes: before a transaction is on disk, and after."""

import subprocess
import sys
from pathlib import Path

import numpy as np

import graincal as gc

from .test_campaign import assert_same, result  # noqa: F401

KILLED = """
import os, signal, sys
sys.path.insert(0, {tests!r})
from contextlib import contextmanager
from pathlib import Path

import graincal as gc
from campaign.hyperbola import SPACE, reference, respond
from campaign.test_campaign import STOP
from graincal.campaign.stored.database import Database
from graincal.campaign.stored.store import holds_campaign

folder, instants = sys.argv[1], [int(each) for each in sys.argv[2:]]
transaction = Database.transaction


def killing(left, after):
    @contextmanager
    def killed(self):
        with transaction(self) as db:
            yield db
            left[0] -= 1
            if not left[0] and not after:
                os.kill(os.getpid(), signal.SIGKILL)  # all is written, and not committed
        if not left[0]:
            os.kill(os.getpid(), signal.SIGKILL)

    Database.transaction = killed


for number, instant in enumerate([*instants, 0]):
    child = os.fork()  # what is imported once need not be imported again
    if child == 0:
        killing([instant or -1], after=number % 2)
        if holds_campaign(Path(folder)):
            gc.resume(folder, gc.PythonModel(respond))
        else:
            gc.calibrate(gc.PythonModel(respond), reference(), SPACE, method="iterative-bayesian", seed=4, stop=STOP, folder=folder, workers=2)
        os._exit(0)
    print(os.waitpid(child, 0)[1], flush=True)
"""


def test_twenty_kills_where_it_writes_change_nothing(result, tmp_path):  # noqa: F811
    script, folder = tmp_path / "script.py", tmp_path / "campaign"
    script.write_text(KILLED.format(tests=str(Path(__file__).parents[1])))
    # Of the transactions of a sitting; the first of all makes the store.
    instants = [1, 1, 2, *np.random.default_rng(0).integers(2, 5, 17).tolist()]
    ended = subprocess.run([sys.executable, script, folder, *map(str, instants)], capture_output=True, text=True, timeout=300)
    assert ended.stdout.split() == ["9"] * 20 + ["0"], ended.stdout + ended.stderr
    found = gc.Result.read(folder)
    assert_same(result, found)
    # Nothing that was stored was run again.
    assert found.attempts.max() == 1
