"""Files from which the deciding thing is taken away, or in which it is contradicted. All else that an expert needs is there.

| name | what is undecided |
|---|---|
| total stresses alone | whether unprimed stresses are total or effective, a back pressure being mentioned |
| unknown unit | what one of the stress is |
| bare stresses | the absolute pressure: kPa, psi or kgf/cm2 |
| mixed strain units | percent or fraction of the one strain that has no unit |
| q against strain | compression or extension: q falls while the axial strain rises |
| stages not told | where shearing begins |
| porosity called void ratio | the density: it is neither the packing's nor that of the strains |
| p and q of half the difference | (s1 - s3)/2 or s1 - s3, in a test without change of volume |
| fractions under percent | whether the sample changes its volume by 4 % or 0.04 % |
| no confining pressure | the pressure of a ratio, or the ratio of a q |
| no measure of strain | 20 % are 0.2 or 0.223 |
| effective and total swapped | which of two columns is effective: the one called so exceeds the other |
| ratio from zero | q/p', q/s3' or R - 1 |
| pore pressure without a total | the effective stress: u and q alone |
| comma of three digits | 12.5 kPa or 12.5 MPa |
| no kind | drained or undrained: q and the axial strain alone |
| two columns disagree | which of q and s1' - s3' is wrong |
| remark against columns | which of the two is wrong |
| loose and dilating | the sign of a volumetric strain, of a sample without a peak |
"""

from __future__ import annotations

import random
from collections.abc import Callable

import numpy as np

from .choice import draw
from .curves import truth
from .draft import Column, Draft, drafted
from .units import PRESSURES
from .words import STYLES

FEW_STRAINS = "axial|axial, volumetric"
COMPRESSION = "drained dense|drained loose"
UNITS_OF_LABORATORIES = "kPa|MPa|bar|psi|kgf/cm2"
UNIT_IN_CELL = "|".join(style for style in STYLES if style not in ("none", "row of units", "two lines"))
"""Styles whose headers can lack a unit; in a row of units a dash would say that there is none."""


def _draft(rng: random.Random, **wanted: str) -> Draft:
    wanted = {"cells": "plain", "stages": "none", **{name.replace("_", " "): levels for name, levels in wanted.items()}}
    return drafted(draw(rng, **wanted), rng)


def total_stresses_alone(rng: random.Random) -> Draft:
    draft = _draft(
        rng,
        family=COMPRESSION,
        stress="totals, u",
        strain=FEW_STRAINS,
        kind_from="remark",
        named="no",
        style="symbols|letters",
        stress_unit=UNITS_OF_LABORATORIES,
    )
    draft.drop("pore_pressure")
    value = f" of {draft.test.back_pressure / 1e3:.0f} kPa" if rng.random() < 0.5 else ""
    draft.remarks["water"] = f"saturated with a back pressure{value}"
    return draft


def unknown_unit(rng: random.Random) -> Draft:
    draft = _draft(rng, stress="q, lateral|axial, lateral|axial|q", named="no")
    unit = rng.choice(["kip/in", "foo", "div", "lbs", "kN/mm", "units"])
    for column in draft.columns:
        column.unit = unit if column.unit in PRESSURES else column.unit
    return draft


def bare_stresses(rng: random.Random) -> Draft:
    draft = _draft(
        rng, family=COMPRESSION, stress="q, lateral|axial, lateral|p, q", strain=FEW_STRAINS, style=UNIT_IN_CELL, named="no", stress_unit=UNITS_OF_LABORATORIES
    )
    for column in draft.columns:
        column.unit = "" if column.unit in PRESSURES else column.unit
    return draft


def mixed_strain_units(rng: random.Random) -> Draft:
    draft = _draft(rng, family=COMPRESSION, strain="axial, volumetric", strain_unit="%", style=UNIT_IN_CELL, named="no", sign="compression positive")
    draft.column("volumetric_strain").unit = ""
    return draft


def q_against_strain(rng: random.Random) -> Draft:
    family, stress = rng.choice([("drained dense", "q, lateral|p, q"), ("drained extension", "q, lateral")])
    draft = _draft(
        rng,
        family=family,
        stress=stress,
        strain="axial",
        sign="compression positive",
        kind_from="option",
        measure_from="option",
        style="symbols|letters|name [unit]",
    )
    column = draft.column("axial_strain" if draft.test.extends else "deviator_stress")
    column.values = -column.values
    return draft


def stages_not_told(rng: random.Random) -> Draft:
    draft = _draft(rng, stages="words|numbers", family="drained dense|drained loose|undrained dilative", kind_from="remark|option")
    draft.stage_column = False
    draft.options.pop("stage")
    return draft


def porosity_called_void_ratio(rng: random.Random) -> Draft:
    draft = _draft(rng, strain="n|axial, volumetric, n|axial, volumetric, e|axial, e|e", style="canonical|name [unit]|name (unit)|symbols|letters")
    quantity = "void_ratio" if any(column.quantity == "void_ratio" for column in draft.columns) else "porosity"
    column = draft.column(quantity)
    column.quantity, column.values = "void_ratio", draft.test.of("porosity")
    column.name = {"canonical": "void_ratio", "symbols": "e", "letters": "e"}.get(draft.choice["style"], "Void ratio")
    column.unit = "-" if draft.choice["style"] in ("name [unit]", "name (unit)") else ""
    return draft


def p_and_q_of_half_the_difference(rng: random.Random) -> Draft:
    draft = _draft(rng, family="undrained contractive|undrained dilative", stress="s, t", style="symbols|letters", named="no")
    draft.column("s").name, draft.column("t").name = "p'", "q"
    return draft


def fractions_under_percent(rng: random.Random) -> Draft:
    strain = rng.choice(["axial, volumetric", "axial, volumetric, e"])
    draft = _draft(rng, family="drained dense", strain=strain, strain_unit="%", sign="compression positive|all negative", kind_from="remark|option")
    draft.options["measure"] = ["--strain", draft.choice["measure"]]
    column = draft.column("volumetric_strain")
    column.values, column.decimals = column.values / 100, 6
    return draft


def no_confining_pressure(rng: random.Random) -> Draft:
    draft = _draft(rng, stress="ratio|q", strain="axial, volumetric|axial, volumetric, e")
    draft.remarks.pop("pressure", None)
    draft.options.pop("pressure", None)
    return draft


def no_measure_of_strain(rng: random.Random) -> Draft:
    # Total stresses that are not called so are asked about before.
    draft = _draft(
        rng, strain="axial|axial, volumetric|axial, radial", measure_from="remark|option", stress="q, lateral|axial, lateral|p, q|lateral, u, q|ratio|q"
    )
    draft.remarks.pop("measure", None)
    draft.options.pop("measure", None)
    return draft


def effective_and_total_swapped(rng: random.Random) -> Draft:
    draft = _draft(
        rng, family=COMPRESSION, stress="total lateral, u, q", strain=FEW_STRAINS, style="symbols|letters|name [unit]|canonical", kind_from="remark|option"
    )
    total = draft.column("total_lateral_stress")
    style = draft.choice["style"]
    names = {"symbols": ("σ3", "σ3'"), "letters": ("sigma3", "sigma3'"), "canonical": ("total_lateral_stress", "lateral_stress")}
    total_name, effective_name = names.get(style, ("Total radial stress", "Effective radial stress"))
    values = draft.test.of("lateral_stress") / total.factor
    effective = Column("lateral_stress", effective_name, total.unit, total.values, total.decimals, total.factor)
    total.name, total.values = total_name, values
    draft.columns.append(effective)
    if rng.random() < 0.5:
        draft.drop("pore_pressure")
    return draft


def ratio_from_zero(rng: random.Random) -> Draft:
    draft = _draft(rng, family="drained loose", stress="ratio", sign="compression positive")
    column = draft.column("stress_ratio")
    column.values = column.values - 1
    column.name = "stress_ratio" if draft.choice["style"] in ("canonical", "none") else "Stress ratio"
    return draft


def pore_pressure_without_a_total(rng: random.Random) -> Draft:
    draft = _draft(rng, family="undrained contractive|undrained dilative", stress="lateral, u, q", kind_from="remark|option")
    draft.drop("lateral_stress")
    return draft


def comma_of_three_digits(rng: random.Random) -> Draft:
    draft = _draft(
        rng, family=COMPRESSION, stress="axial, lateral", strain="axial", strain_unit="permille", stress_unit="kPa", delimiter="semicolon|tab|spaces", sign="compression positive", kind_from="remark|option",
        style="canonical|name [unit]|name (unit)|symbols|letters",
    )  # fmt: skip
    draft.test = truth(draft.choice["family"], rng, pressure=12.5e3)
    for column in draft.columns:
        column.decimals = 3
        if column.quantity != "time":
            column.values = draft.test.of(column.quantity) / column.factor
    strain = draft.column("axial_strain")
    # Whole numbers that rise: no mark in any other column says what the comma is.
    strain.decimals, strain.values = 0, np.arange(len(strain.values)) * 9.0
    draft.choice["decimal"] = "comma"
    if draft.choice["time"] == "yes":
        draft.drop("time")
    return draft


def no_kind(rng: random.Random) -> Draft:
    draft = _draft(rng, family=COMPRESSION, stress="q|ratio", strain="axial")
    draft.remarks.pop("kind", None)
    draft.options.pop("kind", None)
    return draft


def two_columns_disagree(rng: random.Random) -> Draft:
    draft = _draft(
        rng,
        family=COMPRESSION,
        stress="axial, lateral",
        strain=FEW_STRAINS,
        style="canonical|name [unit]|name (unit)|symbols|letters",
        sign="compression positive",
    )
    stress = draft.column("axial_stress")
    share = rng.choice([0.5, 0.8, 1.3])
    name = {"canonical": "deviator_stress", "symbols": "q", "letters": "q"}.get(draft.choice["style"], "Deviator stress")
    draft.columns.append(Column("deviator_stress", name, stress.unit, share * draft.test.of("deviator_stress") / stress.factor, stress.decimals, stress.factor))
    return draft


def remark_against_columns(rng: random.Random) -> Draft:
    draft = _draft(
        rng,
        family="drained dense",
        stress="q, lateral|axial, lateral",
        strain="axial, volumetric|axial, volumetric, e",
        kind_from="remark",
        style="canonical|name [unit]|symbols|letters",
    )
    if rng.random() < 0.5:
        draft.remarks["kind"] = "consolidated undrained triaxial compression test"
    else:
        draft.remarks["pressure"] = f"effective confining pressure: {2 * draft.test.pressure / 1e3:.0f} kPa"
    return draft


def loose_and_dilating(rng: random.Random) -> Draft:
    return _without_sign(_draft(rng, family="drained loose", strain="axial, volumetric", sign="dilation positive"))


def _without_sign(draft: Draft) -> Draft:
    draft.remarks.pop("sign", None)
    return draft


TAKEN: dict[str, Callable[[random.Random], Draft]] = {
    function.__name__.replace("_", " "): function
    for function in (
        total_stresses_alone, unknown_unit, bare_stresses, mixed_strain_units, q_against_strain, stages_not_told, porosity_called_void_ratio,
        p_and_q_of_half_the_difference, fractions_under_percent, no_confining_pressure, no_measure_of_strain, effective_and_total_swapped, ratio_from_zero,
        pore_pressure_without_a_total, comma_of_three_digits, no_kind, two_columns_disagree, remark_against_columns, loose_and_dilating,
    )
}  # fmt: skip


ASKED: dict[str, str] = {
    "total stresses alone": r"\btotal",
    "unknown unit": r'is not a unit|"reference\.units\.\w+_stress"',
    "bare stresses": r'"reference\.units\.\w+_stress"|no unit',
    "mixed strain units": r'"reference\.units\.volumetric_strain"|no unit',
    "q against strain": r'"reference\.compression\.|\bsign|extension|deviator_stress',
    "stages not told": r"where the shear begins|\bstages?\b",
    "porosity called void ratio": r"porosity",
    "p and q of half the difference": r"half_difference_stress",
    "fractions under percent": r'"reference\.units\.volumetric_strain"|volume does not change|strain-too-small',
    "no confining pressure": r'"model\.confining_pressure"|confining pressure',
    "no measure of strain": r'"reference\.strain|engineering or logarithmic',
    "effective and total swapped": r"contradict|\beffective\b.*\btotal|\btotal\b.*\beffective",
    "ratio from zero": r"stress-ratio-low|q/p|stress ratio",
    "pore pressure without a total": r'"model\.confining_pressure"|effective',
    "comma of three digits": r"'\d+,\d{3}'.*whether|thousands",
    "no kind": r'"model\.kind"|drained',
    "two columns disagree": r"contradict",
    "remark against columns": r'"model\.(kind|confining_pressure)".*which is it',
    "loose and dilating": r'"reference\.compression\.volumetric_strain"|dilates',
}
"""What a question, a problem or a refusal has to speak of, for each kind of deprivation, as a regular expression."""


# Files that an expert decides by what soils do, or by figures alone: they may be read rightly or asked about.


def half_the_difference_drained(rng: random.Random) -> Draft:
    """p' - q is constant and p' - q/3 is not."""
    draft = _draft(rng, family=COMPRESSION, stress="s, t", strain="axial, volumetric, e", style="symbols|letters", named="no", sign="compression positive")
    draft.column("s").name, draft.column("t").name = "p'", "q"
    return draft


def stage_not_chosen(rng: random.Random) -> Draft:
    draft = _draft(rng, stages="words")
    draft.options.pop("stage")
    return draft


def bare_stresses_at_a_known_pressure(rng: random.Random) -> Draft:
    draft = _draft(
        rng, family=COMPRESSION, stress="q, lateral|axial, lateral", strain=FEW_STRAINS, style=UNIT_IN_CELL, named="no", stress_unit="kPa|MPa|bar|psi"
    )
    for column in draft.columns:
        column.unit = "" if column.unit in PRESSURES else column.unit
    draft.options["pressure"] = ["--confining-pressure", f"{draft.test.pressure:g}"]
    return draft


def back_pressure_in_a_remark(rng: random.Random) -> Draft:
    """The stresses are called total, and the back pressure has a figure."""
    draft = _draft(rng, family=COMPRESSION, stress="totals, u", strain=FEW_STRAINS, kind_from="remark", named="no", style="canonical")
    draft.drop("pore_pressure")
    draft.remarks["water"] = f"back pressure {draft.test.back_pressure / 1e3:.0f} kPa, constant"
    return draft


def dense_and_dilating(rng: random.Random) -> Draft:
    """Drained sand contracts before it dilates: the sign is not said."""
    return _without_sign(_draft(rng, family="drained dense", strain="axial, volumetric", sign="dilation positive"))


def some_thousands(rng: random.Random) -> Draft:
    """The row of "824" goes before that of "1,012": the comma is no decimal mark."""
    draft = _draft(
        rng,
        family="drained dense",
        stress="q, lateral",
        strain="axial",
        stress_unit="kPa",
        delimiter="semicolon|tab|spaces",
        kind_from="remark|option",
        sign="compression positive",
    )
    draft.test = truth("drained dense", rng, pressure=400e3)
    draft.choice["decimal"] = "point"
    for column in draft.columns:
        if column.unit == "kPa":
            column.values, column.decimals, column.cells = draft.test.of(column.quantity) / column.factor, 0, "thousands"
        elif column.quantity == "axial_strain":
            values = draft.test.axial_strain
            column.values = (1 - np.exp(-values) if draft.choice["measure"] == "engineering" else values) / column.factor
        else:
            column.values = 30.0 * np.arange(len(draft.test.axial_strain))
    return draft


def initial_void_ratio_in_a_remark(rng: random.Random) -> Draft:
    """e = (1 + e0)(1 - engineering strain) - 1, of a specimen that is only shortened."""
    draft = _draft(rng, family="oedometer", strain="axial, e", kind_from="remark|option", measure="engineering")
    draft.drop("void_ratio")
    draft.remarks["density"] = f"initial void ratio {draft.test.initial_void_ratio:.3f}"
    draft.remarks["measure"] = "strains: engineering"
    return draft


OPEN: dict[str, Callable[[random.Random], Draft]] = {
    function.__name__.replace("_", " "): function
    for function in (
        half_the_difference_drained, stage_not_chosen, bare_stresses_at_a_known_pressure, back_pressure_in_a_remark, dense_and_dilating, some_thousands,
        initial_void_ratio_in_a_remark,
    )
}  # fmt: skip
