"""Numbers as people write them: no more digits than are known."""

from __future__ import annotations

import math

ALIKE = 1e-3
"""Errors ε of repeated runs that differ by less than this part, or by less than so many percentage points, are alike: the runs are a millionth of the ranges
apart, and the model does not scatter."""


ROUNDING = 1e-9
"""Part of a number, or percentage points, below which a difference is that of rounding."""


def estimate(mean: float, spread: float) -> str:
    """Mean and standard deviation, two digits of the latter: `28.4 ± 1.1`, `(5.24 ± 0.12) × 10^{8}`."""
    exponent = _exponent(max(abs(mean), spread))
    decimals = _decimals(spread or abs(mean), 2 if spread else 4)
    shown = f"{_fixed(mean, decimals, exponent)} ± {_fixed(spread, decimals, exponent)}"
    return f"({shown}) × 10^{{{exponent}}}".replace("-", "−") if exponent else shown


def least_spread(mean: float) -> float:
    """Of the errors ε of several runs, percent: below it they are alike."""
    return ALIKE * max(abs(mean), 1.0)


def repeated(mean: float, spread: float) -> str:
    """The mean of what several runs gave, with its standard deviation unless they are alike: `4.00 ± 0.13`, `1.57`."""
    return estimate(mean, spread) if spread > least_spread(mean) else value(mean, 3)


def between(low: float, high: float) -> str:
    """The two ends of an interval, two digits of its width: `0.21 to 0.88`; of numbers with a power of ten, the larger at least five times the smaller, two digits of each; the value alone where it has no width but rounding."""
    if high - low <= ROUNDING * max(abs(low), abs(high)):
        return value(high)
    exponent = _exponent(max(abs(low), abs(high)))
    if exponent and 0 < low < 0.2 * high:
        return f"{value(low, 2)} to {value(high, 2)}"
    decimals = _decimals(high - low or abs(high), 2 if high > low else 4)
    shown = f"{_fixed(low, decimals, exponent)} to {_fixed(high, decimals, exponent)}"
    return f"({shown}) × 10^{{{exponent}}}".replace("-", "−") if exponent else shown


def within(number: float, ends: tuple[float, float] | None) -> str:
    """A value to as many decimals as its interval is known to, two digits of the width; to four digits without an interval."""
    if ends is None or not math.isfinite(number) or ends[1] - ends[0] <= ROUNDING * max(map(abs, ends)):
        return value(number)
    exponent = _exponent(max(abs(number), *map(abs, ends)))
    shown = _fixed(number, _decimals(ends[1] - ends[0], 2), exponent)
    return f"{shown} × 10^{{{exponent}}}".replace("-", "−") if exponent else shown


def value(number: float, digits: int = 4) -> str:
    """A number to so many digits; a dash for none."""
    if not math.isfinite(number):
        return "–"
    exponent = _exponent(abs(number))
    shown = _fixed(number, _decimals(abs(number), digits), exponent)
    return f"{shown} × 10^{{{exponent}}}".replace("-", "−") if exponent else shown


def percent(number: float, digits: int = 3) -> str:
    """Percent to so many digits, and to the last before the decimal point in any case: `1.57 %`, `107 %`."""
    if not math.isfinite(number):
        return "– %"
    if abs(number) < ROUNDING:
        return "0 %"
    return f"{number:.{max(_decimals(abs(number), digits), 0)}f} %".replace("-", "−")


def short(number: float) -> str:
    """A number as somebody chose it, to four digits, without the zeros behind: `0.5`, `60`, `2 × 10^{8}`."""
    digits = next(digits for digits in range(1, 5) if digits == 4 or float(f"{number:.{digits}g}") == float(f"{number:.4g}"))
    return value(number, max(digits, 1 + math.floor(math.log10(abs(number))) if 1 <= abs(number) < 1e5 else 1))


def signed(correlation: float) -> str:
    """A correlation: `+0.85`, `−0.12`."""
    return f"{correlation:+.2f}".replace("-", "−")


def pressure(pascals: float) -> str:
    """A pressure in kPa, or from 1 MPa on in MPa."""
    return f"{short(pascals / 1e6)} MPa" if pascals >= 1e6 else f"{short(pascals / 1e3)} kPa"


def duration(seconds: float) -> str:
    """A time in the unit that suits it: `0.8 ms`, `12 s`, `3.4 min`, `2.1 h`."""
    for size, unit in ((3600, "h"), (60, "min"), (1, "s"), (1e-3, "ms")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"


def count(number: int, noun: str) -> str:
    """A number of things: `1 sample`, `80 samples`."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}".replace(",", "\u202f")


def _exponent(size: float) -> int:
    """The power of ten to take out of numbers of a size; 0 where they read well without."""
    power = math.floor(math.log10(size)) if size > 0 else 0
    return 0 if -4 < power < 5 else power


def _decimals(resolved: float, digits: int) -> int:
    return digits - 1 - math.floor(math.log10(resolved)) if resolved > 0 else 0


def _fixed(number: float, decimals: int, exponent: int) -> str:
    # Negative decimals round to tens and hundreds.
    shown = round(number, decimals) / 10.0**exponent
    # What rounds to zero has no sign.
    return f"{shown:z.{max(decimals + exponent, 0)}f}".replace("-", "−")
