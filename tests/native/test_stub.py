"""The types that are declared of the engine are those of the engine that is built."""

import ast
import re
from pathlib import Path

import pytest

import graincal
from graincal import _native

STUB = ast.parse(Path(graincal.__file__).with_name("_native.pyi").read_text(encoding="utf-8"))
CLASSES = {each.name: each for each in STUB.body if isinstance(each, ast.ClassDef)}
SIMULATIONS = ("LinearSimulation", "LinearSimulation32", "HertzSimulation", "HertzSimulation32")


def built(name):
    return [getattr(_native, each) for each in (SIMULATIONS if name == "Simulation" else [name])]


def members(name):
    """The public names of a declared class."""
    functions = {each.name for each in CLASSES[name].body if isinstance(each, ast.FunctionDef)}
    return (functions | {each.target.id for each in CLASSES[name].body if isinstance(each, ast.AnnAssign)}) - {"__init__"}


def parameters(function):
    """The names of a declared function's parameters that can be given by name, without self."""
    arguments = function.args
    return [each.arg for each in (*arguments.args, *arguments.kwonlyargs) if each.arg != "self"]


def test_the_module_has_what_is_declared_and_nothing_else():
    declared = {each.name for each in STUB.body if isinstance(each, (ast.ClassDef, ast.FunctionDef))}
    declared |= {each.target.id for each in STUB.body if isinstance(each, ast.AnnAssign)}
    assert {name for name in dir(_native) if not name.startswith("_")} - set(SIMULATIONS) == declared


@pytest.mark.parametrize("name", list(CLASSES))
def test_a_class_has_what_is_declared_and_nothing_else(name):
    for made in built(name):
        assert {each for each in dir(made) if not each.startswith("_")} == members(name)


@pytest.mark.parametrize("name", list(CLASSES))
def test_what_can_be_given_by_name_has_that_name(name):
    for function in [each for each in CLASSES[name].body if isinstance(each, ast.FunctionDef)]:
        if any(isinstance(each, ast.Name) and each.id == "property" for each in function.decorator_list):
            continue
        whole = _native.Simulation if (name, function.name) == ("Simulation", "__init__") else None
        for made in [whole] if whole else [getattr(each, function.name) for each in built(name)]:
            signature = made.__doc__.partition(") ->")[0]
            assert [each for each in re.findall(r"(\w+): ", signature) if each not in ("self", "arg", "dtype")] == parameters(function), signature
