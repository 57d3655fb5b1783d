"""Models of tests, in a few lines: a function of one sample in place of a simulator. And a campaign that is broken off."""

from contextlib import contextmanager
from dataclasses import dataclass, field
from uuid import uuid4

import pytest

from graincal.campaign.stored.store import Store
from graincal.execution import Task
from graincal.models import Model


@dataclass(eq=False)
class Calls:
    """Work that is a function of its argument; with `run`, one that can be watched: run(argument, watch)."""

    function: object
    key: str = field(default_factory=lambda: uuid4().hex)
    executor = timeout = None
    own_process = False

    def prepare(self):
        pass

    def __call__(self, argument):
        return self.function(argument)


@dataclass(eq=False)
class Watched(Calls):
    def run(self, argument, stopped, watch):
        return self.function(argument, watch)


def as_tasks(respond):
    """`Model.tasks` of a function respond(model, samples, at) that gives the outcome of the one sample in `samples`."""

    def tasks(model, samples, at):
        work = Calls(lambda sample: respond(model, sample, at))
        return [Task(work, samples.take([row])) for row in range(len(samples))]

    return tasks


def model_of(respond):
    """A model whose outcome of one sample is respond(samples, at)."""

    class Some(Model):
        tasks = as_tasks(lambda model, samples, at: respond(samples, at))

    return Some()


@contextmanager
def broken_off(after):
    """Ctrl-C comes when so many evaluations are stored, and nothing is stored any more."""
    record, left = Store.record, [after]

    def interrupted(*arguments):
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        record(*arguments)

    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(Store, "record", interrupted)
        yield
