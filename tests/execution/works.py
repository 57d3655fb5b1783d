"""Work for tests of the scheduler, which processes can import."""

import os
import signal
import subprocess
import threading
import time
from pathlib import Path
from uuid import uuid4


class Work:
    """A function of the argument; by its name here, for a process."""

    timeout = None

    def __init__(self, function, executor=None, own_process=False):
        self.function, self.executor, self.own_process, self.key = function, executor, own_process, uuid4().hex

    def prepare(self):
        if self.function == "always_killed" or (self.function == "killed_once" and not Path(os.environ["KILLED_ONCE"]).exists()):
            if self.function == "killed_once":
                Path(os.environ["KILLED_ONCE"]).touch()
            os.kill(os.getpid(), signal.SIGKILL)

    def __call__(self, argument):
        return (globals()[self.function] if isinstance(self.function, str) else self.function)(argument)


def crashes(argument):
    if argument == "crash":
        os.kill(os.getpid(), signal.SIGKILL)
    return argument


def unsendable(argument):
    return threading.Lock()


def leaves_behind(argument):
    """The number of a process that goes on; and so does a thread."""
    threading.Thread(target=time.sleep, args=(1e5,)).start()
    return subprocess.Popen(["sleep", "1000"]).pid


def killed_once(argument):
    return argument


def always_killed(argument):
    return argument
