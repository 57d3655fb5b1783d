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


_POUND_FORCE, _INCH, _FOOT = 4.4482216152605, 0.0254, 0.3048
"""N, m, m, as they are defined."""

_SYMBOLS = {
    "fraction": {"-": 1.0, "%": 1e-2, "permille": 1e-3, "microstrain": 1e-6},
    "pressure": {
        "Pa": 1.0,
        "hPa": 1e2,
        "kPa": 1e3,
        "MPa": 1e6,
        "GPa": 1e9,
        "mbar": 1e2,
        "bar": 1e5,
        "atm": 101325.0,
        "kgf/cm2": 98066.5,
        "t/m2": 9806.65,
        "N/cm2": 1e4,
        "psi": _POUND_FORCE / _INCH**2,
        "ksi": 1e3 * _POUND_FORCE / _INCH**2,
        "psf": _POUND_FORCE / _FOOT**2,
        "ksf": 1e3 * _POUND_FORCE / _FOOT**2,
        "tsf": 2e3 * _POUND_FORCE / _FOOT**2,
    },
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": _INCH},
    "volume": {"m3": 1.0, "l": 1e-3, "cm3": 1e-6, "mm3": 1e-9, "in3": _INCH**3},
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6},
    "time": {"s": 1.0, "min": 60.0, "h": 3600.0},
}
UNITS = {symbol: Unit(symbol, dimension, factor) for dimension, factors in _SYMBOLS.items() for symbol, factor in factors.items()}

# Other spellings. Upper and lower case are kept apart, for mPa is not MPa; only spellings that can mean nothing else stand here. A ton of tsf is the short one, of 2,000 pounds.
_SPELLINGS = {
    "-": ("", "1", "–", "—", "m/m", "mm/mm", "cm/cm", "in/in", "in./in.", "in./in", "fraction", "dimensionless", "decimal"),
    "%": ("percent", "pct", "Percent", "per cent", "％", "Prozent", "pour cent", "por ciento"),
    "permille": ("‰", "mm/m", "per mille"),
    "microstrain": ("µε", "με", "ue", "um/m", "µm/m", "μm/m"),
    "kPa": ("kpa", "KPa", "KPA", "Kpa", "kN/m2", "kN/m²", "kN/m^2", "KN/m2", "kN·m-2", "кПа", "千帕", "kilopascal", "kilopascals"),
    "MPa": ("Mpa", "MPA", "MN/m2", "MN/m²", "MN/m^2", "N/mm2", "N/mm²", "N/mm^2", "МПа", "兆帕", "megapascal"),
    "Pa": ("pa", "N/m2", "N/m²", "N/m^2", "Па", "帕", "pascal", "pascals"),
    "hPa": ("гПа",),
    "bar": ("Bar", "bars", "бар"),
    "kgf/cm2": ("kgf/cm²", "kgf/cm^2", "kg/cm2", "kg/cm²", "kg/cm^2", "ksc", "KSC", "кгс/см2", "кгс/см²", "kp/cm2", "kp/cm²"),
    "t/m2": ("t/m²", "t/m^2", "tf/m2", "tf/m²", "tf/m^2"),
    "N/cm2": ("N/cm²", "N/cm^2"),
    "psi": ("PSI", "Psi", "lbf/in2", "lbf/in²", "lbf/in^2", "lb/in2", "lb/in²", "lb/in^2", "lbs/in2"),
    "ksi": ("KSI", "kip/in2", "kip/in²", "kip/in^2", "kips/in2"),
    "psf": ("PSF", "lbf/ft2", "lbf/ft²", "lbf/ft^2", "lb/ft2", "lb/ft²", "lb/ft^2", "lbs/ft2"),
    "ksf": ("KSF", "kip/ft2", "kip/ft²", "kip/ft^2", "kips/ft2"),
    "tsf": ("TSF", "ton/ft2", "ton/ft²", "ton/ft^2", "tons/ft2", "tons/ft²", "tons/ft^2"),
    "um": ("µm", "μm"),
    "in": ("inch", "inches", "in."),
    "m3": ("m³", "m^3"),
    "l": ("L", "liter", "litre"),
    "cm3": ("cm³", "cm^3", "cc", "ml", "mL", "c.c.", "мл", "см3", "см³"),
    "mm3": ("mm³", "mm^3", "мм3", "мм³"),
    "in3": ("in³", "in^3", "cu.in", "cu in"),
    "s": ("sec", "seconds", "с"),
    "min": ("minutes", "мин"),
    "h": ("hr", "hours", "ч"),
}
_KNOWN = UNITS | {spelling: UNITS[symbol] for symbol, spellings in _SPELLINGS.items() for spelling in spellings}
_BRACKETED = re.compile(r"^(?P<name>.*\S)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))$")


def find_unit(text: str) -> Unit | None:
    """The unit that is spelled so, if it is known."""
    return _KNOWN.get(" ".join(text.split()))


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
