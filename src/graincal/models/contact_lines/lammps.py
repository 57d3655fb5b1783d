"""Lines for LAMMPS' pair_style granular, run by versions of 29 September 2021 and 22 July 2025: to be included after the atoms are there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from graincal.models.contact_lines.contact import Contact

FILE_NAME = "contact.lammps"

MOST_CLASSES = 10
"""Of radii: LAMMPS wants a line for each pair of them."""

_SAME_SLIP = """\
# The slip is graincal's up to the share of the overlap in the distance of the centres, some 1e-3: graincal's is free of ratcheting, LAMMPS' is not.
# Damping: graincal damps each particle's acceleration (Cundall), for which LAMMPS has nothing. Contacts here have no viscous damping; without
# any (such as fix viscous) a packing does not come to rest. That is yours to choose.
# Units si, atom_style sphere, newton off; comm_modify vel yes; fix nve/sphere moves the spheres."""

_LINEAR = """\
# pair_style granular, linear law. LAMMPS has stiffnesses for pairs of atom types, graincal's depend on both radii:
# kn = 2 E r1 r2 / (r1 + r2), ks = nu kn, km = beta r1 r2 ks, each moment at most eta Fn min(r1, r2).
# So each atom type must stand for one radius.
# LAMMPS' rolling force has the arm r* = r1 r2 / (r1 + r2): k_roll = km / r*^2, mu_roll = eta min(r1, r2) / r*; k_twist = km, mu_twist = eta min(r1, r2)."""

_HERTZ = """\
# pair_style granular, Hertz-Mindlin as graincal has it: shear forces are scaled down where the overlap falls.
{rolling}"""

_NOT_ROLLING = "# There is no resistance to rolling and twisting."
_ROLLING_LEFT_OUT = """\
# NO COUNTERPART: resistance to rolling and twisting (beta_m, eta_m). LAMMPS' stiffness of rolling is a constant, graincal's grows with the root of the
# overlap. It is left out here, so that a packing is weaker than graincal's."""


def lammps_lines(contact: Contact) -> str:
    """The pair style and its coefficients for the spheres that the contact is for. With the linear law, an atom's type follows from its radius."""
    if contact.law == "linear":
        radii, limits = radius_classes(contact.radii)
        body = [_LINEAR, *_said_of(contact, radii, limits), _SAME_SLIP, "pair_style granular", *_pair_coefficients(contact, radii)]
    else:
        body = [_HERTZ.format(rolling=_ROLLING_LEFT_OUT if contact.rolls else _NOT_ROLLING), _SAME_SLIP, "pair_style granular", _hertz_coefficients(contact)]
    return "\n".join([*contact.heading("#"), *body, ""])


def radius_classes(radii: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A radius for each class (C,), ascending, m, and the limits between neighbours (C-1,): the radii (N,) themselves where they are few, or else classes of equal ratio with their mean radii."""
    own = np.unique(radii)
    if len(own) <= MOST_CLASSES:
        return own, 0.5 * (own[1:] + own[:-1])
    limits = np.geomspace(own[0], own[-1], MOST_CLASSES + 1)[1:-1]
    numbers = np.searchsorted(limits, radii)
    filled = np.unique(numbers)
    means = np.array([radii[numbers == number].mean() for number in filled])
    return means, limits[filled[1:] - 1]


def _said_of(contact: Contact, radii: NDArray[np.float64], limits: NDArray[np.float64]) -> Iterator[str]:
    if len(np.unique(contact.radii)) > len(radii):
        yield f"# The radii are put into {len(radii)} classes: the stiffnesses of a contact are off by up to the width of a class."
    edges = [f"{limit:.6g}" for limit in limits]
    for number, (low, radius, high) in enumerate(zip(["0", *edges], radii, [*edges, "all larger ones"]), 1):
        yield f"# Type {number} is for spheres of radius {radius:.6g} m, from {low} to {high}."


def _pair_coefficients(contact: Contact, radii: NDArray[np.float64]) -> Iterator[str]:
    values = radii.tolist()
    for i, first in enumerate(values):
        for j, second in enumerate(values[i:], i):
            pair, reduced = contact.pair(first, second), first * second / (first + second)
            rolling = (
                f" rolling sds {pair.rolling / reduced**2!r} 0.0 {pair.arm / reduced!r} twisting sds {pair.rolling!r} 0.0 {pair.arm!r}" if contact.rolls else ""
            )
            yield f"pair_coeff {i + 1} {j + 1} hooke {pair.normal!r} 0.0 tangential linear_history {pair.shear!r} 0.0 {contact.friction!r}{rolling} damping velocity"


def _hertz_coefficients(contact: Contact) -> str:
    return f"pair_coeff * * hertz/material {contact.modulus!r} 0.0 {contact.values['nu']!r} tangential mindlin_rescale/force NULL 0.0 {contact.friction!r} damping velocity"
