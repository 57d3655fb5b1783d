"""The plain records, as they show themselves."""

import numpy as np

from graincal import Failure, Response


def test_a_response_shows_what_it_holds_on_a_line():
    x = np.linspace(0, 0.2, 51)
    assert repr(Response(x, {"stress_ratio": 1 + x, "a_c": x})) == "Response(51 states: stress_ratio, a_c)"
    assert repr(Response(x, {"stress_ratio": x}, {"flagged": 2, "seconds": 0.1})) == "Response(51 states, 2 flagged: stress_ratio)"


def test_a_failure_shows_its_kind_and_reason():
    assert repr(Failure("diverged", "It ran away.", {"seconds": 2.5})) == "Failure(diverged: It ran away.)"
