"""What a generated file is made of, and which choices go together in a file that an expert can read.

| factor | decides |
|---|---|
| family | the test, see `curves` |
| stress, strain | the columns of stresses and of strains or densities |
| measure, measure from | engineering or logarithmic strain, and what says so: a remark, an option, the void ratio beside the volumetric strain |
| sign, sign from | compression positive, all negative, or dilation positive; the last is said in a remark or proved by the void ratio |
| kind from | what says the kind: a remark, an option, or the columns, as p' - q/3 constant beside a change of volume |
| pressure from | where the confining pressure is: in the columns, a remark or an option |
| stages | rows of saturation and consolidation above, told by numbers, words or the option --rows |
| style, named, delimiter, encoding, decimal, strain unit, stress unit, cells, time | how it is written |

The void ratio of the first state is e0. It proves the measure of the volumetric strain where it is printed beside it; that of the axial one is then an option:
(e0 - e)/(1 + e0) is the engineering one, ln((1 + e0)/(1 + e)) the logarithmic one, 4.5e-4 apart at 3 % and printed to 5e-7 and 3e-6.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Mapping

from .curves import COMPRESSION_LINES, DRAINED, FAMILIES, UNDRAINED
from .units import FRACTIONS, PRESSURES
from .words import ENCODINGS, LANGUAGES, STYLES

Choice = dict[str, str]

STRESSES = {
    "q, lateral": ("deviator_stress", "lateral_stress"),
    "axial, lateral": ("axial_stress", "lateral_stress"),
    "p, q": ("mean_stress", "deviator_stress"),
    "s, t": ("s", "t"),
    "total lateral, u, q": ("total_lateral_stress", "pore_pressure", "deviator_stress"),
    "totals, u": ("total_axial_stress", "total_lateral_stress", "pore_pressure"),
    "lateral, u, q": ("lateral_stress", "pore_pressure", "deviator_stress"),
    "ratio": ("stress_ratio",),
    "q": ("deviator_stress",),
    "q/p": ("deviator_to_mean_stress",),
    "axial": ("axial_stress",),
    "p": ("mean_stress",),
}
STRAINS = {
    "axial": ("axial_strain",),
    "axial, volumetric": ("axial_strain", "volumetric_strain"),
    "axial, volumetric, e": ("axial_strain", "volumetric_strain", "void_ratio"),
    "axial, volumetric, n": ("axial_strain", "volumetric_strain", "porosity"),
    "axial, radial": ("axial_strain", "radial_strain"),
    "axial, e": ("axial_strain", "void_ratio"),
    "e": ("void_ratio",),
    "n": ("porosity",),
    "volumetric, e": ("volumetric_strain", "void_ratio"),
}
FOUR = ("q, lateral", "axial, lateral", "p, q", "s, t")
WITH_WATER = ("total lateral, u, q", "totals, u")
WITHOUT_PRESSURE = ("ratio", "q", "q/p")
PROVED = ("axial, volumetric, e", "axial, volumetric, n")
ENGLISH_STYLES = ("canonical", "name [unit]", "name (unit)", "row of units")


def _stress(chosen: Choice) -> tuple[str, ...]:
    family = chosen["family"]
    if family == "drained extension":
        return ("q, lateral", "axial, lateral", "p, q", *WITH_WATER, "ratio")
    if family in DRAINED:
        return (*FOUR, *WITH_WATER, *WITHOUT_PRESSURE)
    if family == "undrained extension":
        return ("q, lateral", "axial, lateral", "p, q", *WITH_WATER, "lateral, u, q")
    if family in UNDRAINED:
        return (*FOUR, *WITH_WATER, "lateral, u, q")
    return FOUR if family == "constant mean stress" else ("axial",) if family == "oedometer" else ("p", "axial, lateral")


def _strain(chosen: Choice) -> tuple[str, ...]:
    family = chosen["family"]
    if family in UNDRAINED:
        return ("axial",)
    if family in COMPRESSION_LINES:
        return ("e", "n", "axial, e") if family == "oedometer" else ("e", "n", "volumetric, e")
    return ("axial", "axial, volumetric", "axial, volumetric", *PROVED, "axial, radial", "axial, e")


def _measure_from(chosen: Choice) -> tuple[str, ...]:
    if chosen["family"] in COMPRESSION_LINES:
        return ("not needed",)
    return ("void ratio",) if chosen["strain"] in PROVED else ("remark", "option")


def _sign(chosen: Choice) -> tuple[str, ...]:
    signs = ["compression positive"]
    if chosen["stress"] in ("q, lateral", "axial, lateral", "p, q", "axial", "p"):
        signs.append("all negative")
    if "axial, volumetric" in chosen["strain"]:
        signs.append("dilation positive")
    return tuple(signs)


def _sign_from(chosen: Choice) -> tuple[str, ...]:
    if chosen["sign"] != "dilation positive":
        return ("columns",)
    return ("remark", "void ratio") if chosen["strain"] in PROVED else ("remark",)


def _kind_from(chosen: Choice) -> tuple[str, ...]:
    family, stress, strain = chosen["family"], chosen["stress"], chosen["strain"]
    if family.endswith("extension") and stress == "ratio":
        return ("remark",)
    proved = {
        "oedometer": strain == "axial, e",
        "isotropic cycle": stress == "axial, lateral",
        "isotropic one way": stress == "axial, lateral",
    }.get(family, "u" in stress if family in UNDRAINED else strain != "axial" and stress not in WITHOUT_PRESSURE)
    return ("remark", "option", "columns") if proved else ("remark", "option")


def _stages(chosen: Choice) -> tuple[str, ...]:
    fit = (
        chosen["family"] not in COMPRESSION_LINES
        and chosen["stress"] in ("q, lateral", "axial, lateral", *WITH_WATER)
        and chosen["strain"] in ("axial", "axial, volumetric")
        and chosen["sign"] == "compression positive"
        and chosen["kind from"] != "columns"
    )
    return ("none", "numbers", "words", "rows") if fit else ("none",)


def _style(chosen: Choice) -> tuple[str, ...]:
    if chosen["stages"] != "none":
        return ENGLISH_STYLES
    barred: set[str] = set()
    if chosen["stress"] == "s, t":
        barred |= {"canonical", "none", *LANGUAGES}
    if chosen["stress"] in ("ratio", "q/p"):
        barred |= {*LANGUAGES}
    if chosen["stress"] == "ratio" and chosen["family"] == "drained extension":
        barred |= {"name [unit]", "name (unit)", "name, unit", "row of units", "two lines", "in a comment"}
    if chosen["family"] in UNDRAINED and chosen["stress"] == "p, q":
        barred |= {"symbols", "letters"}
    return tuple(style for style in STYLES if style not in barred)


def _named(chosen: Choice) -> tuple[str, ...]:
    if chosen["style"] == "none":
        return ("yes",)
    if chosen["stress"] == "s, t":
        return ("no",)
    return ("yes", "no") if chosen["style"] in LANGUAGES else ("no", "no", "no", "yes")


def _encoding(chosen: Choice) -> tuple[str, ...]:
    unicode = ("utf-8", "utf-8-sig", "utf-16")
    if chosen["style"] == "symbols" or (chosen["stress"] == "ratio" and chosen["style"] not in ("canonical", "letters", "none")):
        return unicode
    own = ENCODINGS.get(chosen["style"], "cp1252")
    return (*unicode, own, own)


def _strain_unit(chosen: Choice) -> tuple[str, ...]:
    return ("none",) if chosen["strain"] in ("e", "n") else tuple(FRACTIONS)


def _stress_unit(chosen: Choice) -> tuple[str, ...]:
    return ("none",) if chosen["stress"] in ("ratio", "q/p") else tuple(PRESSURES)


def _cells(chosen: Choice) -> tuple[str, ...]:
    cells = ["plain", "plain"]
    if chosen["strain unit"] == "%" and chosen["style"] not in ("none", "canonical"):
        cells.append("percent")
    large = chosen["family"] == "drained dense" or chosen["family"] in COMPRESSION_LINES
    if chosen["stress unit"] == "Pa" or (chosen["stress unit"] in ("kPa", "kN/m2") and large):
        cells.append("thousands")
    return tuple(cells)


FACTORS: Mapping[str, Callable[[Choice], tuple[str, ...]]] = {
    "family": lambda chosen: FAMILIES,
    "stress": _stress,
    "strain": _strain,
    "measure": lambda chosen: ("engineering", "logarithmic"),
    "measure from": _measure_from,
    "sign": _sign,
    "sign from": _sign_from,
    "kind from": _kind_from,
    "pressure from": lambda chosen: ("remark", "option") if chosen["stress"] in WITHOUT_PRESSURE else ("columns",),
    "stages": _stages,
    "style": _style,
    "named": _named,
    "delimiter": lambda chosen: ("comma", "semicolon", "tab", "spaces"),
    "encoding": _encoding,
    "decimal": lambda chosen: ("point", "comma"),
    "strain unit": _strain_unit,
    "stress unit": _stress_unit,
    "cells": _cells,
    "time": lambda chosen: ("no", "no", "yes"),
}


def draw(rng: random.Random, **wanted: str) -> Choice:
    """Choices that go together, those that are wanted among them; a wanted value may list several, as "a|b"."""
    while True:
        chosen: Choice = {}
        for factor, levels in FACTORS.items():
            possible = [level for level in levels(chosen) if level in wanted.get(factor, level).split("|")]
            if not possible:
                break
            chosen[factor] = rng.choice(possible)
        else:
            return chosen


def balanced(rng: random.Random, seen: Counter[tuple[str, str]], tries: int = 40) -> Choice:
    """Of some draws the one whose levels have been seen least."""
    best = max((draw(rng) for _ in range(tries)), key=lambda chosen: sum(1 / (1 + seen[level]) ** 2 for level in chosen.items()))
    seen.update(best.items())
    return best
