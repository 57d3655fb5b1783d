"""The largest file and the longest function of Python packages: python tools/layout.py FOLDER ... (blank lines and comments count, docstrings do not count in functions)."""

import ast
import sys
from pathlib import Path


def longest(path: Path) -> tuple[int, str]:
    """Lines of the longest function of a file, without its docstring, and its name."""
    found = (0, "")
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            docstring = node.body[0] if ast.get_docstring(node) else None
            lines = node.end_lineno - node.lineno + 1 - (docstring.end_lineno - docstring.lineno + 1 if docstring else 0)
            found = max(found, (lines, f"{path.name}:{node.name}"))
    return found


for folder in map(Path, sys.argv[1:]):
    files = sorted(path for path in folder.rglob("*.py") if "tests" not in path.parts)
    lines, largest = max((len(path.read_text(encoding="utf-8").splitlines()), str(path.relative_to(folder))) for path in files)
    of_function, function = max(map(longest, files))
    print(f"{folder}: {len(files)} files; the largest {largest} ({lines} lines); the longest function {of_function} lines, {function}")
