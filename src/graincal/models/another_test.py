"""The same grains in another test."""

from __future__ import annotations

from dataclasses import fields

from graincal.models.element_tests import TESTS
from graincal.models.stress_path import STRAINS, StressPathTest

_OF_THE_PATH = ("control", "table", "turns")


def another_test(test: StressPathTest, kind: str, *, confining_pressure: float | None = None, control: str = "") -> StressPathTest:
    """A test along another path, a key of `TESTS`, by the packing, the contact law and all other settings of a test. confining_pressure: Pa, that of the test by default. control: the path's first by default."""
    target = TESTS[kind]
    settings = {field.name: getattr(test, field.name) for field in fields(target) if hasattr(test, field.name) and field.name not in _OF_THE_PATH}
    control = control or target.controls[0]
    if control not in STRAINS:
        settings["rest_every"] = None
    if confining_pressure is not None:
        settings["confining_pressure"] = float(confining_pressure)
    return target(**settings, control=control)
