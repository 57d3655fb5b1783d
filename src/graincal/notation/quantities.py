"""What parameters, observables and other quantities are called on axes and in sentences, and the unit they are shown in."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from graincal.notation import numbers

if TYPE_CHECKING:
    from graincal.data import ParameterSpace

_GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "eps": "ε", "zeta": "ζ", "eta": "η", "theta": "θ", "kappa": "κ",
    "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "chi": "χ", "psi": "ψ", "omega": "ω",
}  # fmt: skip
_LOGARITHM = re.compile(r"log_\{10\} ?(?:\[(.+)\]|\((.+)\)|(.+))")
_DIMENSIONLESS = ("nu", "beta_m", "eta_m")


@dataclass(frozen=True)
class Quantity:
    """A quantity as it is shown: `label` in markup, `unit`, and the factor from SI units and plain fractions to that unit."""

    label: str
    unit: str = ""
    scale: float = 1.0

    @property
    def axis(self) -> str:
        """The label of an axis."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    @property
    def behind(self) -> str:
        """The unit as it stands behind a number, with a space; nothing where there is none."""
        return f" {self.unit}" if self.unit not in ("", "-") else ""

    @property
    def title(self) -> str:
        """The label to begin a line with: a word gets a capital, a symbol keeps its letter."""
        first = self.label.split()[0]
        return self.label[0].upper() + self.label[1:] if len(first) > 1 and first.isalpha() else self.label

    @property
    def antilog(self) -> Quantity | None:
        """What this is the logarithm of, to base 10: E in GPa for log E in log_{10} Pa; None for what is no such logarithm."""
        found = _LOGARITHM.fullmatch(self.unit)
        if found is None or not self.label.startswith("log "):
            return None
        label, unit = self.label.removeprefix("log "), next(filter(None, found.groups()))
        return Quantity(label, "GPa", 1e-9) if unit == "Pa" else Quantity(label, unit)

    def raised(self, *values: float) -> tuple[float, ...]:
        """What values are the logarithms of, in the unit of `antilog`; () for what is no logarithm."""
        antilog = self.antilog
        return tuple(antilog.scale * 10.0**value for value in values) if antilog else ()

    def without_log(self, *values: float) -> str:
        """What a value, or both ends of an interval, is the logarithm of, to stand behind it: ` (E 0.347 GPa)`, ` (E from 0.302 to 0.348 GPa)`; nothing for what is no logarithm."""
        antilog = self.antilog
        if antilog is None:
            return ""
        plain = self.raised(*values)
        return f" ({antilog.label} {numbers.value(plain[0], 3) if plain[0] == plain[-1] else f'from {numbers.between(*plain)}'}{antilog.behind})"


_KNOWN = {
    "stress_ratio": Quantity("stress ratio σ_{1}/σ_{3}", "-"),
    "void_ratio": Quantity("void ratio e", "-"),
    "coordination_number": Quantity("coordination number Z", "-"),
    "a_c": Quantity("a_{c}", "-"),
    "a_n": Quantity("a_{n}", "-"),
    "a_t": Quantity("a_{t}", "-"),
    "mean_stress": Quantity("mean stress p", "kPa", 1e-3),
    "deviatoric_stress": Quantity("deviatoric stress q", "kPa", 1e-3),
    "deviator_stress": Quantity("deviator stress q", "kPa", 1e-3),
    "axial_stress": Quantity("axial stress σ_{1}", "kPa", 1e-3),
    "lateral_stress": Quantity("lateral stress σ_{3}", "kPa", 1e-3),
    "excess_pore_pressure": Quantity("excess pore pressure Δu", "kPa", 1e-3),
    "axial_extension": Quantity("axial extension", "%", 100.0),
    "unbalanced_force": Quantity("unbalanced force", "-"),
    "position": Quantity("position Σ|Δ ln σ|"),
}


def quantity(name: str) -> Quantity:
    """An observable, a control variable or a quantity of interest by its name. Strains are shown in percent."""
    if name in _KNOWN:
        return _KNOWN[name]
    words = name.replace("_", " ")
    return Quantity(words, "%", 100.0) if words.endswith("strain") else Quantity(words)


def parameters(space: ParameterSpace) -> tuple[Quantity, ...]:
    """The parameters of a space, in their own units; one experiment's value of a parameter has the experiment's name after the symbol."""
    return tuple(parameter(name, unit) for name, unit in zip(space.names, space.units))


def parameter(name: str, unit: str) -> Quantity:
    """A parameter by its name, which has an experiment's name in brackets behind it where it has a value in each, and by its unit."""
    base = name.partition(" (")[0]
    return Quantity(symbol(base) + name.removeprefix(base), re.sub(r"^log10\b", "log_{10}", unit or ("-" if base in _DIMENSIONLESS else "")))


def symbol(name: str) -> str:
    """A parameter's name in markup: `φ` for phi, `β_{m}` for beta_m, `log E` for log_E; other names as they are."""
    if name.startswith("log_"):
        return f"log {symbol(name[4:])}"
    base, _, index = name.partition("_")
    letter = _GREEK.get(base) or (base if len(base) == 1 else None)
    if letter is None or len(index) > 3 or not (index or "x").isalnum():
        return name.replace("_", " ")
    return f"{letter}_{{{index}}}" if index else letter
