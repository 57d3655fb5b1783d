"""The engine, which native/cpu/module.cpp binds."""

from typing import Any

def __getattr__(name: str) -> Any: ...
