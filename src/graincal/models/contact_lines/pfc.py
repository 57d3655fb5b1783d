"""Lines for PFC 6 and 7, by the formulas of its manual: they were never run, for PFC needs a licence."""

from __future__ import annotations

from graincal.models.contact_lines.contact import Contact

FILE_NAME = "contact.dat"

_NOT_RUN = """\
; NOT RUN: these lines follow the formulas of PFC's manual. No PFC was there to try them: compare the forces of two balls before you use them.
; Damping: "ball attribute damp 0.2" is Cundall's local damping, as in graincal's tests while they load (0.9 while they come to rest).
; Density: graincal scales it to take fewer steps. The grains' own density is {density!r} kg/m^3."""

_LINEAR = """\
; Manual, Contact Models, Linear Model: stiffnesses that are inherited from the two balls act in series, kn = kn1 kn2 / (kn1 + kn2). With kn = 2 E r of
; each ball this is graincal's kn = 2 E r1 r2 / (r1 + r2); likewise ks = nu kn. (The "deformability" method is another: kn = pi min(r)^2 emod / (r1 + r2).)
{rolling}
{damping}
contact cmat default type ball-ball model {model} inheritance kn on ks on fric on property dp_nratio 0.0 dp_sratio 0.0
fish define graincal_balls
  loop foreach local b ball.list
    ball.prop(b, "kn") = 2.0 * {modulus!r} * ball.radius(b)
    ball.prop(b, "ks") = {nu!r} * 2.0 * {modulus!r} * ball.radius(b)
    ball.prop(b, "fric") = {friction!r}
  endloop
end
[graincal_balls]
"""

_ROLLING = """\
fish define graincal_rolling(c)
  local r1 = ball.radius(contact.end1(c))
  local r2 = ball.radius(contact.end2(c))
  graincal_rolling = {eta_m!r} * math.min(r1, r2) * (r1 + r2) / (r1 * r2)
end
fish define graincal_contact(entries)
  local c = entries(1)
  contact.prop(c, "rr_fric") = graincal_rolling(c)
end
contact property rr_fric @graincal_rolling range contact type "ball-ball"
fish callback add graincal_contact event contact_activated
"""

_HERTZ = """\
; Manual, Contact Models, Hertz Model: with hz_alpha = 1.5, G = E / (2 (1 + nu)) and the same material of both balls, Fn = 4 G sqrt(r*) un^1.5 / (3 (1 - nu)),
; r* = r1 r2 / (r1 + r2), and ks = 2 (1 - nu) / (2 - nu) dFn/dun: graincal's forces. hz_mode 1 scales shear forces down where the overlap falls, as graincal does.
{rolling}
{damping}
contact cmat default type ball-ball model hertz property hz_shear {shear_modulus!r} hz_poiss {nu!r} hz_alpha 1.5 hz_mode 1 fric {friction!r} dp_nratio 0.0 dp_sratio 0.0
"""

_NOT_ROLLING = "; There is no resistance to rolling and twisting."
_ROLLING_STRENGTH_ALONE = """\
; Rolling Resistance Linear Model: the moment is at most rr_fric R Fn with 1/R = 1/r1 + 1/r2, so rr_fric = eta min(r1, r2) / R gives graincal's strength.
; NO COUNTERPART: the stiffness beta_m = {beta_m!r}: the model's own is kr = ks R^2, graincal's beta r1 r2 ks (for equal balls, beta = 0.25 would be the same).
; NO COUNTERPART: resistance to twisting: the model has none."""
_ROLLING_LEFT_OUT = """\
; NO COUNTERPART: resistance to rolling and twisting (beta_m, eta_m): PFC's Hertz model has none. A packing is weaker than graincal's."""


def pfc_lines(contact: Contact) -> str:
    """Commands and FISH functions for the default contacts of balls."""
    return "\n".join([*contact.heading(";"), _linear(contact) if contact.law == "linear" else _hertz(contact)])


def _linear(contact: Contact) -> str:
    rolls = contact.rolls
    said = _ROLLING_STRENGTH_ALONE.format(**contact.values) if rolls else _NOT_ROLLING
    lines = _LINEAR.format(
        rolling=said,
        damping=_NOT_RUN.format(density=contact.density),
        model="rrlinear" if rolls else "linear",
        modulus=contact.modulus,
        friction=contact.friction,
        **contact.values,
    )
    return lines + (_ROLLING.format(**contact.values) if rolls else "")


def _hertz(contact: Contact) -> str:
    shear_modulus = contact.modulus / (2 * (1 + contact.values["nu"]))
    said = _ROLLING_LEFT_OUT if contact.rolls else _NOT_ROLLING
    return _HERTZ.format(
        rolling=said, damping=_NOT_RUN.format(density=contact.density), shear_modulus=shear_modulus, friction=contact.friction, **contact.values
    )
