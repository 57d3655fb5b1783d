"""Expressions that a user writes, such as `10**log_E` or `stage == 2`: parsed with a list of what is allowed, and never run as Python."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, reduce
from typing import Any

import numpy as np

Value = Any
"""A number, or an array of numbers (T,); truth values where an expression compares."""

LONGEST = 2_000
"""Characters of an expression."""

DEEPEST = 150
"""Brackets, signs and terms of an expression within one another, which are computed one within another too."""

FUNCTIONS: dict[str, Callable[..., Value]] = {
    "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "log10": np.log10, "log2": np.log2,
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2,
    "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "radians": np.radians, "degrees": np.degrees,
    "abs": np.abs, "floor": np.floor, "ceil": np.ceil, "round": np.round,
    "min": lambda *values: reduce(np.minimum, values), "max": lambda *values: reduce(np.maximum, values),
}  # fmt: skip
"""What an expression may call; `log` is the natural logarithm."""

CONSTANTS = {"pi": np.float64(np.pi)}

_ARGUMENTS = {"atan2": (2, 2), "min": (2, 20), "max": (2, 20)}
"""How many arguments a function takes, at the least and at the most; all others take one."""

_OPERATORS: dict[type[ast.AST], Callable[..., Value]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: operator.pow, ast.Mod: operator.mod, ast.FloorDiv: operator.floordiv,
    ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Not: np.logical_not, ast.And: np.logical_and, ast.Or: np.logical_or,
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip


class NotAnExpression(ValueError):
    """A text is no expression that is allowed. The message says why, as the end of a sentence."""


@dataclass(frozen=True)
class Expression:
    """An expression of names, numbers, + - * / // % **, comparisons, `and`, `or`, `not`, `a if b else c`, and the functions of `FUNCTIONS`.

    >>> Expression("10**log_E * pi")({"log_E": 2})
    np.float64(314.1592653589793)

    Raises NotAnExpression for anything else. It can be sent anywhere, for it holds nothing but its text.
    """

    text: str

    def __post_init__(self) -> None:
        _parsed(self.text)

    @property
    def names(self) -> tuple[str, ...]:
        """The names that it takes values of, in their order."""
        found = sorted((node.lineno, node.col_offset, node.id) for node in ast.walk(_parsed(self.text)) if isinstance(node, ast.Name))
        return tuple(name for name in dict.fromkeys(name for *_, name in found) if name not in FUNCTIONS and name not in CONSTANTS)

    @property
    def compares(self) -> bool:
        """Whether its value is true or false, and no number."""
        node = _parsed(self.text)
        return isinstance(node, (ast.Compare, ast.BoolOp)) or (isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not))

    def __call__(self, values: Mapping[str, Value]) -> Value:
        """Its value at these values of its names, all of which are numbers or arrays of one length. What overflows is infinite, and what is undefined is NaN. Raises KeyError for a name without a value."""
        with np.errstate(all="ignore"):
            return _value(_parsed(self.text), {name: np.asarray(values[name], dtype=np.float64)[()] for name in self.names} | CONSTANTS)


@lru_cache(maxsize=1_000)
def _parsed(text: str) -> ast.expr:
    if len(text) > LONGEST:
        raise NotAnExpression(f"it has {len(text)} characters, and at most {LONGEST:,} are allowed")
    try:
        found = ast.parse(text.strip(), mode="eval").body
        if _depth(found) > DEEPEST:
            raise NotAnExpression("it has too many brackets, signs or terms in one another")
        _check(found)
    except SyntaxError as error:
        raise NotAnExpression(f"it cannot be read ({error.msg}){_meant(text)}") from None
    except (RecursionError, MemoryError, ValueError) as error:
        if isinstance(error, NotAnExpression):
            raise
        raise NotAnExpression("it cannot be read") from None
    return found


def _meant(text: str) -> str:
    """What is written otherwise in other languages, as the end of a sentence; empty where it is none of these."""
    for theirs, ours in (("&&", "and"), ("||", "or"), ("=>", ">="), ("=<", "<=")):
        if theirs in text:
            return f'; "{ours}" was expected in the place of "{theirs}"'
    if re.search("(?<![<>=!])=(?!=)", text):
        return "; a comparison such as < or == was expected in the place of ="
    return ""


def _depth(node: ast.AST) -> int:
    """How many nodes lie within one another at the most."""
    depth, level = 0, [node]
    while level:
        depth, level = depth + 1, [inner for each in level for inner in ast.iter_child_nodes(each)]
    return depth


def _check(node: ast.expr) -> None:
    """Raise NotAnExpression for anything that is not allowed."""
    match node:
        case ast.Constant(value=value) if isinstance(value, (int, float)) and not isinstance(value, bool):
            if not -1e300 < value < 1e300:
                raise NotAnExpression("a number in it is too large")
        case ast.Name(id=name):
            if name in FUNCTIONS:
                raise NotAnExpression(f"{name} is a function, and {name}(...) was expected")
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
            fewest, most = _ARGUMENTS.get(name, (1, 1))
            if not fewest <= len(arguments) <= most:
                raise NotAnExpression(f"{name} takes {fewest}{f' to {most}' if most > fewest else ''} arguments, and {len(arguments)} are given")
            for argument in arguments:
                _check(argument)
        case ast.Call(func=ast.Name(id=name)):
            raise NotAnExpression(f"there is no function {name}, and one of {', '.join(FUNCTIONS)} was expected")
        case ast.BinOp(op=op) | ast.UnaryOp(op=op) | ast.BoolOp(op=op) if type(op) in _OPERATORS:
            for part in _parts(node):
                _check(part)
        case ast.Compare(ops=operators) if all(type(op) in _OPERATORS for op in operators):
            for part in _parts(node):
                _check(part)
        case ast.IfExp():
            for part in (node.test, node.body, node.orelse):
                _check(part)
        case ast.BinOp(op=ast.BitXor() | ast.BitAnd() | ast.BitOr() as op):
            theirs, ours = _OTHERS[type(op)]
            raise NotAnExpression(f'it has {theirs} in it, and "{ours}" was expected in its place')
        case _:
            raise NotAnExpression(
                f"it has {_SAID.get(type(node), type(node).__name__)} in it, and only names, numbers, + - * / // % **, comparisons, and, or, not and functions are allowed"
            )


_OTHERS = {ast.BitXor: ("^", "**"), ast.BitAnd: ("&", "and"), ast.BitOr: ("|", "or")}
"""Operators of other languages, and what they are here."""

_SAID = {
    ast.Attribute: "a point between names",
    ast.Subscript: "square brackets behind a name",
    ast.Constant: "a text",
    ast.List: "a list",
    ast.Tuple: "a comma",
    ast.Call: "a call",
}


def _parts(node: ast.expr) -> list[ast.expr]:
    match node:
        case ast.BinOp():
            return [node.left, node.right]
        case ast.UnaryOp():
            return [node.operand]
        case ast.BoolOp():
            return node.values
        case ast.Compare():
            return [node.left, *node.comparators]
    return []


def _value(node: ast.expr, values: Mapping[str, Value]) -> Value:
    match node:
        case ast.Constant(value=int() | float() as number):
            # A float: whole numbers of any length would take any time.
            return np.float64(number)
        case ast.Name():
            return values[node.id]
        case ast.Call(func=ast.Name(id=name)):
            return FUNCTIONS[name](*(_value(argument, values) for argument in node.args))
        case ast.IfExp():
            return np.asarray(np.where(_value(node.test, values), _value(node.body, values), _value(node.orelse, values)))[()]
        case ast.Compare():
            found = [_value(part, values) for part in _parts(node)]
            return reduce(np.logical_and, [_OPERATORS[type(op)](left, right) for op, left, right in zip(node.ops, found, found[1:])])
    assert isinstance(node, (ast.BinOp, ast.UnaryOp, ast.BoolOp)), "anything else was refused as it was read"
    found = [_value(part, values) for part in _parts(node)]
    return reduce(_OPERATORS[type(node.op)], found) if len(found) > 1 else _OPERATORS[type(node.op)](found[0])
