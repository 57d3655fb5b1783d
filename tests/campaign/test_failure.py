"""A Failure is made by anybody's model: whatever it is made of, it can be shown, sent and stored."""

import math
import pickle

import numpy as np
import pytest

from graincal import Failure
from graincal.campaign import Calibration, Experiment
from graincal.campaign.stored.store import Store
from graincal.data import InputError, Samples

from .hyperbola import SPACE, model, reference


class Hostile(dict):
    def items(self):
        raise RuntimeError("no")


class Number(float):
    def __float__(self):
        raise RuntimeError("no")


@pytest.mark.parametrize("kind", [None, 3, b"error", "", "\n"])
def test_a_kind_that_is_no_text_is_an_error(kind):
    assert Failure(kind, "why.").kind == "error"


def test_kind_and_reason_are_printable_and_short():
    failure = Failure("timed\x1b out" * 20, "a\x1b[2J\nb\udce9\u202e" + "c" * 5_000_000)
    assert failure.kind.startswith(r"timed\x1b_out") and len(failure.kind) <= 50 and not set(failure.kind) & set(" \x1b")
    assert failure.reason.startswith(r"a\x1b[2J b\udce9\u202eccc") and failure.reason.endswith("c…") and len(failure.reason) == 1000
    assert Failure("diverged", "It ran away.") == Failure("diverged", "It ran away.", {})
    assert Failure("error", None).reason == "None"


@pytest.mark.parametrize("details", [None, 3, "text", Hostile(a=1), {"a": "b"}, {3: 4}, {"a": [1]}, {"a": 10**400}, {"a": Number(1)}, {"a": 1j}, {"a": None}])
def test_details_that_are_no_numbers_are_left_out(details):
    assert Failure("error", "no.", details).details == {}


def test_details_that_are_numbers_are_kept_as_floats():
    details = Failure("error", "no.", {"a": 1, "b": np.float32(0.5), "c": math.nan, "d": -math.inf, "e": True, "f\x1b": 2, "g": np.int64(3)}).details
    assert all(type(value) is float for value in details.values()) and math.isnan(details.pop("c"))
    assert details == {"a": 1.0, "b": 0.5, "d": -math.inf, "e": 1.0, r"f\x1b": 2.0, "g": 3.0}


@pytest.mark.parametrize("failure", [Failure("a\udce9", "b\udce9", {"c\udce9": 1}), Failure(lambda: 0, lambda: 0, {"a": lambda: 0}), Failure("", "\x00")])
def test_it_can_be_sent_and_stored(failure):
    assert pickle.loads(pickle.dumps(failure)) == failure
    store = Store.create(Calibration(SPACE, [Experiment("one", model(), reference())]))
    store.ask(0, Samples(np.arange(1), np.full((1, 2), 0.5), SPACE.names), 1)
    store.record(0, 0, failure)
    assert store.outcome(0, 0) == failure


def test_a_message_quotes_nothing_that_a_terminal_obeys():
    assert str(InputError("a\x1b[2J\u202eb\nc")) == "a\\x1b[2J\\u202eb\nc"
    assert len(str(InputError("a" * 50_000))) == 10_000
