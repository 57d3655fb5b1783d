"""Engineering or logarithmic strain: what the void ratio or the strains of the other axes prove, what is said, and what has to be asked."""

from __future__ import annotations

import numpy as np

from graincal.errors import InputError
from graincal.laboratory.decisions import UNANSWERED
from graincal.laboratory.quantities import STRAINS
from graincal.laboratory.understanding import remarks
from graincal.laboratory.understanding.case import Case
from graincal.laboratory.understanding.strains import multiplied, proof


def decide_measures(case: Case, read: tuple[str, ...]) -> None:
    """Set the measure of each strain that is read (of `read`): proven, said by the person, said by the file, or asked."""
    proven: dict[str, tuple[str, str]] = {name: found for name in ("volumetric_strain", "axial_strain") if name in read and (found := _proven(case, name))}
    for name, (measure, because) in proven.items():
        case.measures[name] = measure
        case.decide(f"strain.{name}", measure, because)
    said = remarks.strain_measure((*case.words, *case.table.header))
    known = case.known.strain
    for name in read:
        given = known if known is None or isinstance(known, str) else known.get(name)
        if name in proven:
            if given and given != proven[name][0]:
                raise InputError(f"{case.table.path}: {name} is said to be {given} strain, and it is {proven[name][0]} strain, because {proven[name][1]}.")
            continue
        if given:
            case.measures[name] = given
            if said and said != given:
                case.notes.append(f"The file speaks of {said} strain, and you of {given} strain: yours is taken.")
        elif said:
            case.measures[name] = said
            case.decide(f"strain.{name}", said, "the file says so in words", by="words")
        else:
            case.measures[name] = UNANSWERED
    _ask(case, next((measure for measure, _ in proven.values()), "engineering"))


def _ask(case: Case, proposed: str) -> None:
    asked = [name for name, measure in case.measures.items() if measure == UNANSWERED]
    if not asked:
        return
    key = "strain" if len(asked) == len(case.measures) else f"strain.{asked[0]}"
    names = " and ".join(name.replace("_", " ") for name in asked)
    other = f" The rest is {proposed}." if len(asked) < len(case.measures) else " Laboratories mostly print engineering strain, simulations logarithmic."
    case.ask(
        key,
        f"Whether {names} {'is' if len(asked) == 1 else 'are'} engineering or logarithmic cannot be seen from the numbers.{other}",
        ("engineering", "logarithmic"),
        proposed,
        "--strain",
    )


def _proven(case: Case, name: str) -> tuple[str, str] | None:
    column, ratio = case.column(name), case.void_ratios
    if case.summed:
        # The strains of the axes add up to the volumetric one only where all are logarithmic.
        total = np.sum([each.values for each in case.summed], axis=0)
        found = None if ratio is None else proof(total, 3 * min(each.digits for each in case.summed), ratio, case.void_ratio_digits, None)
        return (
            ("logarithmic", "the strains of the three axes add up to the logarithm of the change of volume")
            if found and found.measure == "logarithmic"
            else None
        )
    if column is None:
        return None
    if ratio is not None and (name == "volumetric_strain" or case.kind == "oedometric"):
        found = proof(column.values, column.digits, ratio, case.void_ratio_digits, column.unit.symbol if column.unit else None)
        if found and found.measure:
            return found.measure, f"the void ratio changes with {column.label} as it does by {found.measure} strain"
    axial, volumetric, radial = (case.column(each) for each in STRAINS)
    if axial is not None and volumetric is not None and radial is not None:
        signs = [case.strain_sign.get(each.quantity, 1.0) for each in (axial, volumetric)]
        digits = max(each.last_digit for each in (axial, volumetric, radial))
        if multiplied(signs[0] * axial.plain, signs[0] * radial.plain, signs[1] * volumetric.plain, digits):
            return "engineering", "the strains of the axes multiply, as lengths do, and do not add up to the volumetric strain"
    return None
