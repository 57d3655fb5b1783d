"""Units that laboratory files print, and how a header carries one."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Unit:
    """A unit: `factor` makes a printed number SI (a plain fraction for strains and ratios)."""

    symbol: str
    dimension: str
    factor: float


_SYMBOLS = {
    "fraction": {"-": 1.0, "%": 1e-2, "permille": 1e-3, "microstrain": 1e-6},
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5, "psi": 6894.757293168361, "kgf/cm2": 98066.5},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6},
    "time": {"s": 1.0, "min": 60.0, "h": 3600.0},
}
UNITS = {symbol: Unit(symbol, dimension, factor) for dimension, factors in _SYMBOLS.items() for symbol, factor in factors.items()}

# Other spellings. Upper and lower case are kept apart, for mPa is not MPa; only spellings that can mean nothing else stand here.
_SPELLINGS = {
    "-": ("", "1", "–", "—", "m/m", "mm/mm", "fraction"),
    "%": ("percent", "pct", "Percent"),
    "permille": ("‰", "mm/m"),
    "microstrain": ("µε", "με", "ue"),
    "kPa": ("kpa", "KPa", "KPA", "kN/m2", "kN/m²", "kN/m^2"),
    "MPa": ("Mpa", "MPA", "MN/m2", "MN/m²", "MN/m^2", "N/mm2", "N/mm²", "N/mm^2"),
    "Pa": ("pa", "N/m2", "N/m²", "N/m^2"),
    "kgf/cm2": ("kgf/cm²", "kgf/cm^2", "kg/cm2", "kg/cm²", "kg/cm^2"),
    "um": ("µm", "μm"),
    "s": ("sec",),
}
_KNOWN = UNITS | {spelling: UNITS[symbol] for symbol, spellings in _SPELLINGS.items() for spelling in spellings}
_BRACKETED = re.compile(r"^(?P<name>.*\S)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))$")


def find_unit(text: str) -> Unit | None:
    """The unit that is spelled so, if it is known."""
    return _KNOWN.get(text.strip())


def known_units(dimension: str | None) -> str:
    """The known units of a dimension (all of them for None), as a list to read."""
    return ", ".join(symbol for symbol, unit in UNITS.items() if dimension in (None, unit.dimension))


def split_header(header: str) -> tuple[str, str | None]:
    """A header's name and the text of the unit in brackets behind it: `axial_strain [%]` and `Ea(%)` carry `%`, `q` none."""
    found = _BRACKETED.match(header)
    if found is None:
        return header, None
    unit = found["square"] if found["square"] is not None else found["round"]
    return found["name"], unit.strip()
