"""Processes that end with the one that started them, however that ends.

python -m graincal.execution.tied MODULE [ARGUMENT ...]      runs a module as `python -m MODULE` does, in such a process
"""

from __future__ import annotations

import ctypes
import os
import runpy
import signal
import sys

from graincal.execution.interrupts import ENDING

_SET_DEATH_SIGNAL = 1
"""PR_SET_PDEATHSIG of Linux."""


def end_with(owner: int) -> None:
    """Have the system kill this process when its owner ends, or the thread of it that started this one. owner: the parent's number, which is another one where it has ended already."""
    ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != owner:
        os.kill(os.getpid(), signal.SIGKILL)


if __name__ == "__main__":
    end_with(os.getppid())
    # A Ctrl-C and a logout reach all processes of a terminal: this one ends when its owner says so, by SIGTERM.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    sys.argv = sys.argv[1:]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
