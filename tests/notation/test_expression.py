"""Expressions that people write: what they come to, and that nothing else than arithmetic can be written."""

import numpy as np
import pytest

from graincal.notation.expression import Condition, Expression, ExpressionError


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("10**log_E / (2 * (1 + nu))", 1e8 / 2.5),
        ("-a**2 + +b", -9 + 0.5),
        ("min(a, b, 0.1) + max(a, 7)", 7.1),
        ("sqrt(a) * abs(-a) + exp(log(a)) - log10(1e3)", np.sqrt(3) * 3),
        ("tan(radians(45)) + degrees(pi)", 181.0),
        ("  a\n+ b ", 3.5),
        ("ϕ", 30.0),
    ],
)
def test_arithmetic_is_computed_as_it_is_written(source: str, expected: float) -> None:
    values = {"log_E": 8.0, "nu": 0.25, "a": 3.0, "b": 0.5, "φ": 30.0}
    assert Expression(source, values)(values) == pytest.approx(expected, rel=1e-14)


def test_arrays_are_computed_element_by_element() -> None:
    a = np.linspace(-1, 1, 5)
    np.testing.assert_array_equal(Expression("2 * a + 1", ["a"])({"a": a}), 2 * a + 1)
    np.testing.assert_array_equal(Condition("0 <= a < b or a == -1", ["a", "b"])({"a": a, "b": 1.0}), [True, False, True, True, False])


def test_what_no_number_is_does_not_hold_and_what_is_too_large_is_infinite() -> None:
    assert np.isinf(Expression("9.0**9**9**9", [])({})) and np.isnan(Expression("sqrt(0 - 1)", [])({}))
    undefined = Condition("sqrt(a) != 5 or log(a) < 0", ["a"])
    assert not undefined({"a": -1.0}) and undefined({"a": 0.5})


def test_a_margin_is_above_zero_where_a_condition_holds() -> None:
    rng = np.random.default_rng(0)
    values = {"a": rng.uniform(-1, 1, 1000), "b": rng.uniform(-1, 1, 1000)}
    for source in ("a < b", "b >= a > -0.5", "a > 0.5 or b < a**2 and b != 0", "(a < 0 or b < 0) and a + b > -1"):
        condition = Condition(source, values)
        np.testing.assert_array_equal(condition.margin(values) > 0, condition(values))


def test_the_names_that_are_used_are_known() -> None:
    assert Expression("b + a * b + pi", ["a", "b", "c"]).used == ("b", "a")


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("a + c", r'"a \+ c" names c, which is not known; one of a, beta was expected'),
        ("bta", 'did you mean "beta"'),
        ("a^2", r"holds a\^2, and a power is written with \*\*"),
        ("__import__('os').system('true')", "holds __import__"),
        ("a.real", "holds a.real"),
        ("(lambda: 1)()", "holds"),
        ("[x for x in (1,)]", "holds"),
        ("a if a else beta", "holds"),
        ("'a' * 3", "holds 'a'"),
        ("a + True", "holds True"),
        ("1j", "holds 1j"),
        ("a // 2", "holds"),
        ("sqrt", "names sqrt"),
        ("sqrt(a, beta)", "gives sqrt 2 numbers, and one was expected"),
        ("max(a)", "gives max 1 numbers, and two or more was expected"),
        ("max(*a)", "holds"),
        ("1" + "0" * 400, "too large"),
        ("9" * 990, "too large"),
        ("a <", "cannot be read as an expression"),
        ("", "an expression in text was expected"),
        ("(" * 400 + "a" + ")" * 400, "cannot be read as an expression"),
        ("-" * 900 + "a", "more than 150 parts within one another"),
        ("a" * 1001, "1,001 characters"),
        ("a < beta", "holds a < beta"),
        ("a\0", "cannot be read"),
    ],
)
def test_whatever_else_is_refused_in_a_clause(source: str, said: str) -> None:
    with pytest.raises(ExpressionError, match=said) as caught:
        Expression(source, ["a", "beta"])
    assert len(str(caught.value)) < 500 and not str(caught.value).endswith(".")


@pytest.mark.parametrize("source", ["a", "a + 1", "not a < 1", "a < 1 and a", "a in a", "a is a", "(a < 1) + 2"])
def test_a_condition_compares(source: str) -> None:
    with pytest.raises(ExpressionError, match="is no condition: a comparison such as"):
        Condition(source, ["a"])
