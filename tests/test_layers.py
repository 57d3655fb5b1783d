"""The layers of the house: a module imports those of its own layer and of the layers below, never one above."""

import ast
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import graincal

ROOT = Path(graincal.__file__).parent

LAYERS = [
    ["lazily", "build", "suggestion", "notation"],
    ["errors"],
    ["arrays", "constraint", "drawing"],
    ["notebook"],
    ["parameter_space"],
    ["files", "positions"],
    ["laboratory", "grainlearning"],
    ["data"],
    ["interpolation", "execution", "dem"],
    ["models"],
    ["inference.likelihood", "inference.sampling"],
    ["inference.driving", "inference.emulator"],
    ["inference.iterative", "inference.posterior"],
    ["inference"],
    ["campaign.asked"],
    ["campaign.stored"],
    ["campaign.found"],
    ["campaign.file", "report"],
    ["result"],
    ["campaign"],
    ["watching"],
    ["demo", "studies"],
    ["cli"],
]
"""From the lowest to the highest. Packages in one line do not know each other, or are one thing: those that do stand in FRIENDS."""

FRIENDS = {("dem", "interpolation"), ("inference.driving", "inference.emulator")}


def _name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {_name(path): path for path in ROOT.rglob("*.py")}


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """All statements that run: those that are there for type checkers alone do not."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        yield node
        yield from _statements(node)


def _exports(package: str) -> dict[str, str]:
    """Name -> module, of a package that exports names of others: at once, or when they are first used."""
    found = {}
    for node in _statements(ast.parse(MODULES[package].read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("graincal."):
            found |= {alias.name: node.module.removeprefix("graincal.") for alias in node.names}
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "exported":
            found |= {name: module.removeprefix("graincal.") for module, names in ast.literal_eval(node.args[1]).items() for name in names}
    return found


FACADES = {name: _exports(name) for name, path in MODULES.items() if path.name == "__init__.py"}


def _module(package: str, name: str) -> str:
    """The module that a name comes from, through whatever exports it."""
    if f"{package}.{name}".lstrip(".") in MODULES:
        return f"{package}.{name}".lstrip(".")
    source = FACADES.get(package, {}).get(name)
    return package if source is None else _module(source, name)


def _imports(module: str) -> set[str]:
    found = set()
    for node in _statements(ast.parse(MODULES[module].read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "graincal":
            found |= {_module(node.module.removeprefix("graincal").lstrip("."), alias.name) for alias in node.names}
    return found - {"", module}


def _layer(module: str) -> tuple[int, str]:
    return next((number, name) for number, layer in enumerate(LAYERS) for name in layer if f"{module}.".startswith(f"{name}."))


PLACED = sorted(name for name in MODULES if name)


@pytest.mark.parametrize("package", sorted({_layer(module)[1] for module in PLACED}))
def test_a_package_imports_from_lower_layers_alone(package: str) -> None:
    wrong = []
    for module in (each for each in PLACED if _layer(each)[1] == package):
        for other in _imports(module):
            below, name = _layer(other)
            here = _layer(module)[0]
            if name != package and (below > here or (below == here and tuple(sorted((name, package))) not in FRIENDS)):
                wrong.append(f"{module} imports {other}")
    assert not wrong


def test_no_module_imports_itself_through_others() -> None:
    imports = {module: {other for other in _imports(module) if other in PLACED} for module in PLACED if MODULES[module].name != "__init__.py"}
    list(TopologicalSorter(imports).static_order())
