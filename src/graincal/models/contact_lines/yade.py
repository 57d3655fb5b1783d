"""Lines for YADE, run by version 2023.02a: Python, to be imported or pasted into a script."""

from __future__ import annotations

from graincal.models.contact_lines.contact import Contact

FILE_NAME = "contact.py"

_DAMPING = """\
# Motion: NewtonIntegrator(damping=0.2) is the damping of graincal's tests while they load, 0.9 while they come to rest.
# Density: graincal scales it to take fewer steps. This is the grains' own density."""

_LINEAR = """\
# The same forces and moments as graincal's: kn = 2 E r1 r2 / (r1 + r2), ks = nu kn, km = beta r1 r2 ks, each moment at most eta Fn min(r1, r2).
{damping}
from math import radians

from yade import *

material = CohFrictMat(
    density={density!r},  # kg/m^3
    young={modulus!r},  # Pa
    poisson={nu!r},  # ks / kn
    frictionAngle=radians({phi!r}),
    isCohesive=False,
    momentRotationLaw=True,
    alphaKr={beta_m!r},
    alphaKtw={beta_m!r},
    etaRoll={eta_m!r},
    etaTwist={eta_m!r},
)
contact_loop = InteractionLoop(
    [Ig2_Sphere_Sphere_ScGeom6D()],
    [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys()],
    [Law2_ScGeom6D_CohFrictPhys_CohesionMoment(useIncrementalForm=True, always_use_moment_law=True)],
)
# O.materials.append(material), spheres of it, and contact_loop among O.engines.
"""

_HERTZ = """\
# The same normal and shear forces as graincal's while the overlap grows. Where it falls, YADE keeps the shear force and graincal scales it down.
{rolling}
{damping}
from math import radians

from yade import *

material = FrictMat(
    density={density!r},  # kg/m^3
    young={modulus!r},  # Pa, of the grains
    poisson={nu!r},  # of the grains
    frictionAngle=radians({phi!r}),
)
contact_loop = InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()], [Law2_ScGeom_MindlinPhys_Mindlin()])
# O.materials.append(material), spheres of it, and contact_loop among O.engines.
"""

_NOT_ROLLING = "# There is no resistance to rolling and twisting."
_ROLLING_LEFT_OUT = """\
# NO COUNTERPART: resistance to rolling and twisting (beta_m, eta_m). YADE's stiffness of rolling is one number for all contacts, graincal's grows with
# radii and overlap. It is left out here, so that a packing is weaker than graincal's."""


def yade_lines(contact: Contact) -> str:
    """The material and the interaction loop of a contact law."""
    body = _LINEAR if contact.law == "linear" else _HERTZ
    rolling = _ROLLING_LEFT_OUT if contact.rolls else _NOT_ROLLING
    return "\n".join(
        [*contact.heading("#"), body.format(density=contact.density, modulus=contact.modulus, rolling=rolling, damping=_DAMPING, **contact.values)]
    )
