"""Arithmetic and conditions that somebody wrote as text, over names that are known: parsed with a list of what is allowed, and never run as code."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Collection, Mapping
from functools import reduce
from unicodedata import normalize

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graincal.notation.printable import printable
from graincal.suggestion import did_you_mean

LONGEST = 1_000
"""Characters of an expression."""

DEEPEST = 150
"""Parts of an expression within one another: what is computed part by part must not fill Python's stack. A sum of so many terms is one."""

FUNCTIONS: Mapping[str, Callable[..., NDArray[np.float64]]] = {
    "abs": np.abs, "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "log10": np.log10,
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "radians": np.radians, "degrees": np.degrees,
}  # fmt: skip
"""Functions of one number. `log` is the natural logarithm; angles are in radians."""

OF_SEVERAL: Mapping[str, Callable[..., NDArray[np.float64]]] = {"min": np.minimum, "max": np.maximum}
"""Functions of two numbers or more."""

CONSTANTS = {"pi": np.pi}

_ARITHMETIC = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: operator.pow}
_SIGNS = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_COMPARISONS: Mapping[type, Callable[..., NDArray[np.bool_]]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq, ast.NotEq: lambda a, b: np.abs(a - b) > 0,
}  # fmt: skip
_MARGINS: Mapping[type, Callable[..., NDArray[np.float64]]] = {
    ast.Lt: lambda a, b: b - a, ast.LtE: lambda a, b: b - a, ast.Gt: lambda a, b: a - b, ast.GtE: lambda a, b: a - b,
    ast.Eq: lambda a, b: -np.abs(a - b), ast.NotEq: lambda a, b: np.abs(a - b),
}  # fmt: skip


class ExpressionError(ValueError):
    """A text that is no expression, or uses what is not allowed. The message is a clause that quotes the text, without a full stop."""


class Expression:
    """Arithmetic such as `10**log_E / (2 * (1 + nu))`, of float64.

    source: the text. names: those that it may use; each is a number, or an array, when it is computed. `used` are those that it does use, in their order there.
    It knows + - * / **, brackets, numbers, `pi`, and `FUNCTIONS` and `OF_SEVERAL`. A name that Python would not take for one (`k [1]`, `lambda`) cannot stand in it.
    Raises ExpressionError.
    """

    def __init__(self, source: str, names: Collection[str]) -> None:
        self.source = source
        # Python reads names in this form, as φ for ϕ.
        self._names = {normalize("NFKC", name): name for name in names}
        self._tree = _parsed(source)
        self._used: dict[str, None] = {}
        self._check(self._tree)
        self.used = tuple(self._used)

    def __call__(self, values: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
        """The number, or the numbers where values are arrays; infinite or NaN where there is none."""
        with np.errstate(all="ignore"):
            return np.asarray(self._number(self._tree, values), dtype=np.float64)

    def _check(self, tree: ast.expr) -> None:
        """Raise ExpressionError where it is not of the kind that is expected."""
        self._check_arithmetic(tree)

    def _check_arithmetic(self, node: ast.expr) -> None:
        """Raise ExpressionError for whatever is not allowed."""
        match node:
            case ast.Constant(value=bool()):
                raise self._not_allowed(node)
            case ast.Constant(value=float() | int() as number):
                self._check_number(number)
            case ast.Name(id=name):
                self._check_name(name)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _ARITHMETIC:
                self._check_arithmetic(left)
                self._check_arithmetic(right)
            case ast.UnaryOp(op=op, operand=operand) if type(op) in _SIGNS:
                self._check_arithmetic(operand)
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if (name in FUNCTIONS or name in OF_SEVERAL) and not any(isinstance(each, ast.Starred) for each in arguments):
                self._check_arguments(name, arguments)
            case _:
                raise self._not_allowed(node)

    def _check_number(self, number: float) -> None:
        try:
            finite = np.isfinite(float(number))
        except OverflowError:
            finite = False
        if not finite:
            raise ExpressionError(f"{self._shown} holds a number that is too large")

    def _check_name(self, name: str) -> None:
        if name in self._names:
            self._used[self._names[name]] = None
        elif name not in CONSTANTS:
            known = ", ".join(self._names.values()) or "nothing"
            raise ExpressionError(f"{self._shown} names {printable(name)}, which is not known{did_you_mean(name, self._names)}; one of {known} was expected")

    def _check_arguments(self, function: str, arguments: list[ast.expr]) -> None:
        if function in FUNCTIONS and len(arguments) != 1 or function in OF_SEVERAL and len(arguments) < 2:
            raise ExpressionError(f"{self._shown} gives {function} {len(arguments)} numbers, and {'one' if function in FUNCTIONS else 'two or more'} was expected")
        for argument in arguments:
            self._check_arithmetic(argument)

    def _not_allowed(self, node: ast.AST) -> ExpressionError:
        part = printable(ast.get_source_segment(_in_one_line(self.source), node) or self.source, 60)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitXor):
            return ExpressionError(f"{self._shown} holds {part}, and a power is written with **")
        functions = ", ".join([*FUNCTIONS, *OF_SEVERAL])
        return ExpressionError(f"{self._shown} holds {part}, and numbers, names, + - * / ** and {functions} were expected")

    def _number(self, node: ast.expr, values: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
        match node:
            case ast.Constant(value=number):
                return np.float64(number)
            case ast.Name(id=name):
                return np.asarray(values[self._names[name]] if name in self._names else CONSTANTS[name], dtype=np.float64)
            case ast.BinOp(left=left, op=op, right=right):
                return _ARITHMETIC[type(op)](self._number(left, values), self._number(right, values))
            case ast.UnaryOp(op=op, operand=operand):
                return _SIGNS[type(op)](self._number(operand, values))
            case ast.Call(func=ast.Name(id=name), args=arguments):
                numbers = [self._number(argument, values) for argument in arguments]
                return FUNCTIONS[name](*numbers) if name in FUNCTIONS else reduce(OF_SEVERAL[name], numbers)
        raise AssertionError(ast.dump(node))

    @property
    def _shown(self) -> str:
        return f'"{printable(self.source, 100)}"'


class Condition(Expression):
    """A condition such as `0 < v0 < v1 or v1 > 3`: arithmetic compared by < <= > >= == !=, with `and`, `or` and brackets."""

    def __call__(self, values: Mapping[str, ArrayLike]) -> NDArray[np.bool_]:
        """Whether it holds. A comparison with a number that there is none of (the root of a negative one) does not."""
        with np.errstate(all="ignore"):
            return self._combined(self._tree, values, _COMPARISONS, np.logical_and, np.logical_or)

    def margin(self, values: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
        """How far it is from not holding, in the unit of what is compared: above 0 where it holds, below where it does not."""
        with np.errstate(all="ignore"):
            return self._combined(self._tree, values, _MARGINS, np.minimum, np.maximum)

    @property
    def has_equality(self) -> bool:
        """Whether == stands in it, which hardly any number meets."""
        return any(isinstance(node, ast.Eq) for node in ast.walk(self._tree))

    def _check(self, node: ast.expr) -> None:
        match node:
            case ast.BoolOp(values=parts):
                for part in parts:
                    self._check(part)
            case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in _COMPARISONS for op in ops):
                for part in (left, *others):
                    self._check_arithmetic(part)
            case _:
                raise ExpressionError(f'{self._shown} is no condition: a comparison such as "a < b", or several with and or or, was expected')

    def _combined(self, node: ast.expr, values: Mapping[str, ArrayLike], of: Mapping[type, Callable], both: Callable, either: Callable) -> NDArray:
        if isinstance(node, ast.BoolOp):
            return reduce(both if isinstance(node.op, ast.And) else either, [self._combined(part, values, of, both, either) for part in node.values])
        numbers = [self._number(part, values) for part in (node.left, *node.comparators)]
        return reduce(both, [np.asarray(of[type(op)](a, b)) for op, a, b in zip(node.ops, numbers, numbers[1:])])


def _parsed(source: str) -> ast.expr:
    if not isinstance(source, str) or not source.strip():
        raise ExpressionError("an expression in text was expected")
    if len(source) > LONGEST:
        raise ExpressionError(f'"{printable(source, 60)}" has {len(source):,} characters, and at most {LONGEST:,} were expected')
    try:
        tree = ast.parse(_in_one_line(source), mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise ExpressionError(f'"{printable(source, 100)}" cannot be read as an expression') from None
    if _depth(tree) > DEEPEST:
        raise ExpressionError(f'"{printable(source, 100)}" has more than {DEEPEST} parts within one another')
    return tree



def _in_one_line(source: str) -> str:
    # Without brackets around it Python would end an expression with its line.
    return " ".join(source.split())


def _depth(tree: ast.AST) -> int:
    """How many parts of an expression stand in one another at most."""
    depth, level = 0, [tree]
    while level:
        depth, level = depth + 1, [child for node in level for child in ast.iter_child_nodes(node)]
    return depth
