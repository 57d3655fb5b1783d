"""Functions that are named as "module:name", and what their exceptions say."""

from __future__ import annotations

import importlib
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

from graincal.data import InputError


def find_function(name: str, folder: Path | None = None) -> Callable:
    """The function that is named "module:name"; its module is looked for in `folder` first, which joins the search path.

    Raises InputError where there is no such module or function, or where importing the module fails.
    """
    module_name, colon, attribute = name.partition(":")
    if not (module_name and colon and attribute):
        raise InputError(f'function must be named as "module:name", not "{name}".')
    if folder is not None and str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    where = f"in {folder} or among the installed packages" if folder else "among the installed packages"
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name == module_name or module_name.startswith(f"{error.name}."):
            raise InputError(f"function {name}: there is no module {module_name} {where}.") from None
        raise InputError(f"function {name}: importing {module_name} failed ({describe_exception(error)}).") from error
    except Exception as error:
        raise InputError(f"function {name}: importing {module_name} failed ({describe_exception(error)}).") from error
    _refuse_namesake(name, module_name, getattr(module, "__file__", None), folder)
    function: object = module
    for part in attribute.split("."):
        function = getattr(function, part, None)
    if not callable(function):
        raise InputError(f"function {name}: {module_name} ({getattr(module, '__file__', 'built in')}) has no function {attribute}.")
    return function


def _refuse_namesake(name: str, module: str, loaded: str | None, folder: Path | None) -> None:
    """A module that was imported before is found again whatever the folder; it may be another of the same name."""
    places = [Path(folder, *module.split(".")).with_suffix(".py"), Path(folder, *module.split("."), "__init__.py")] if folder else []
    own = next((path for path in places if path.exists()), None)
    if own and (loaded is None or Path(loaded).resolve() != own.resolve()):
        raise InputError(f"function {name}: another module named {module} is loaded already ({loaded or 'built in'}), so that {own} needs another name.")


def describe_exception(error: BaseException) -> str:
    """The exception and the place where it was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    # The first frame is the caller's.
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if len(frames) > 1 else ""
    return f"{type(error).__name__}: {error}{place}"
