"""Expressions that users write: what they give, and that nothing else is run."""

import math
import pickle
import re

import numpy as np
import pytest

from graincal.notation.expression import Expression, NotAnExpression


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10**log_E", 10**8.5), ("a + b*2 - -a / 4", 2 + 6 + 0.5), ("sin(radians(30))", 0.5), ("min(a, b, 7) + max(a, b)", 2 + 3), ("pi", math.pi),
        ("a if a > b else b", 3), ("log(exp(a))", 2), ("7 % a", 1), ("7 // a", 3), ("a < b <= 3 and not a == b", True), ("a > b or a == 2", True),
    ],
)  # fmt: skip
def test_values(text, expected):
    assert Expression(text)({"a": 2, "b": 3, "log_E": 8.5}) == pytest.approx(expected, rel=1e-15)


def test_arrays_are_taken_element_by_element():
    stage = np.array([1.0, 2.0, 2.0, 3.0])
    np.testing.assert_array_equal(Expression("stage == 2 and not time > 1")({"stage": stage, "time": np.arange(4)}), [False, True, False, False])
    np.testing.assert_array_equal(Expression("max(stage, 2)")({"stage": stage}), [2, 2, 2, 3])


def test_what_overflows_is_infinite_and_what_is_undefined_is_not_a_number():
    assert Expression("10**x")({"x": 400}) == math.inf
    assert Expression("1 / x")({"x": 0}) == math.inf
    assert math.isnan(Expression("log(x)")({"x": -1}))
    assert Expression("10**10**10")({}) == math.inf


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')", "a.real", "a[0]", "(lambda: 1)()", "'text'", "f'{a}'", "[a]", "(a, b)", "{a}", "a := 1", "a; b", "import os", "sqrt", "sqrt(1, 2)", "min(1)",
        "open(a)", "abs(a, key=b)", "a if b", "", "1j", "True", "a @ b", "a << b", "a is b", "a in b", "[x for x in a]", "1" * 400, "(" * 500 + "a" + ")" * 500, "a" * 3000, "a\x00", "-" * 600 + "a",
    ],
)  # fmt: skip
def test_anything_else_is_refused(text):
    with pytest.raises(NotAnExpression):
        Expression(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a < 1 && b < 2", '"and" was expected in the place of "&&"'),
        ("a < 1 || b < 2", '"or" was expected in the place of "||"'),
        ("a => 1", '">=" was expected in the place of "=>"'),
        ("a = 1", "a comparison such as < or == was expected in the place of ="),
        ("a > b^2", 'it has ^ in it, and "**" was expected in its place'),
        ("(a < 1) & (b < 2)", 'it has & in it, and "and" was expected in its place'),
    ],
)
def test_what_is_written_otherwise_in_other_languages_is_said(text, said):
    with pytest.raises(NotAnExpression, match=re.escape(said)):
        Expression(text)


def test_what_is_read_can_be_computed_beneath_other_calls():
    def beneath(calls):
        return beneath(calls - 1) if calls else Expression("-" * 148 + "a")({"a": 1.0})

    assert beneath(400) == 1


def test_names_are_known_and_an_expression_can_be_sent():
    found = pickle.loads(pickle.dumps(Expression("10**log_E + sqrt(b) * pi + b")))
    assert found.names == ("log_E", "b") and found({"log_E": 0, "b": 0}) == 1
    assert Expression("a < b").compares and not Expression("a + b").compares
