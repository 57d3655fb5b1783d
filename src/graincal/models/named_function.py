"""Functions that are named as "module:name", and what their exceptions say."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from graincal.data import LONGEST_NAME, InputError
from graincal.notation.printable import as_text, printable

LONGEST_MESSAGE = 800
"""Characters of an exception's own message: the place where it was raised stands behind it."""


def find_function(name: str, folder: Path | None = None) -> Callable:
    """The function that is named "module:name", of a file module.py in `folder`, or else of a module that can be imported.

    The folder joins the search path, for what the module imports from beside itself. Raises InputError where there is no such module or function,
    or where importing the module fails.
    """
    module_name, _, attribute = name.partition(":")
    if not (module_name and attribute):
        raise InputError(f'function must be named as "module:name", not "{name}".')
    try:
        module = _load(module_name, folder)
    # Whatever it is, SystemExit too: it ends the search and nothing else.
    except BaseException as error:
        if isinstance(error, ModuleNotFoundError) and error.name in (module_name, module_name.partition(".")[0]):
            where = f"in {folder} or among the installed packages" if folder else "among the installed packages"
            raise InputError(f"function {name}: there is no module {module_name} {where}.") from None
        raise InputError(f"function {name}: importing {module_name} failed ({describe_exception(error)}).") from error
    function: Any = module
    for part in attribute.split("."):
        function = getattr(function, part, None)
    if not callable(function):
        raise InputError(f"function {name}: {getattr(module, '__file__', module_name)} has no function {attribute}.")
    return function


def _load(name: str, folder: Path | None) -> ModuleType:
    if folder is not None and str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    path = folder / f"{name}.py" if folder else None
    if path is None or not path.exists():
        return importlib.import_module(name)
    # By its file: modules of the same name in other folders, or in Python itself, are others.
    key = f"{name} of {path.resolve()}"
    if key not in sys.modules:
        spec = importlib.util.spec_from_file_location(key, path)
        assert spec is not None and spec.loader is not None, "a .py file has a loader"
        sys.modules[key] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(sys.modules[key])
        except BaseException:
            del sys.modules[key]
            raise
    return sys.modules[key]


def describe_exception(error: BaseException) -> str:
    """The exception and the place where it was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    # The first frame is the caller's.
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if len(frames) > 1 else ""
    try:
        said = printable(as_text(str(error)), LONGEST_MESSAGE)
    except BaseException:
        said = "without a message that could be read"
    return f"{printable(type(error).__name__, LONGEST_NAME)}: {said}{place}"
