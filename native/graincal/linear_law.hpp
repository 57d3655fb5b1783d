// Linear springs with sliding, rolling and twisting resistance: Hartmann, Cheng, Thornton (2022), Table 1.
#pragma once

#include "contact.hpp"

namespace graincal {

template <class Real> struct LinearLaw {
    Real modulus;            // E, Pa
    Real stiffness_ratio;    // nu = ks / kn
    Real friction;           // tan(phi)
    Real rolling_stiffness;  // beta_m
    Real rolling_strength;   // eta_m

    template <class Other> LinearLaw<Other> in_precision() const {
        return {Other(modulus), Other(stiffness_ratio), Other(friction), Other(rolling_stiffness), Other(rolling_strength)};
    }

    ContactStiffness<Real> stiffness(const TouchingPair<Real>& pair) const {
        const Real product = pair.radius1 * pair.radius2;
        const Real normal = Real(2) * modulus * product / (pair.radius1 + pair.radius2);
        const Real shear = stiffness_ratio * normal;
        return {normal, shear, rolling_stiffness * product * shear};
    }

    // Zero without contact, as of every law.
    Real normal_force(const TouchingPair<Real>& pair, const ContactStiffness<Real>& k) const { return k.normal * maximum(pair.overlap, Real(0)); }

    // The contact's memory one step on.
    ContactHistory<Real> advance(const TouchingPair<Real>& pair, const ContactStiffness<Real>& k, Real normal_force, Real dt,
                                 const ContactHistory<Real>& before) const {
        return advance_resistances(pair, k, normal_force, friction, rolling_strength, dt, before);
    }

    // Energy held in the springs of a contact, J.
    Real elastic_energy(const ContactStiffness<Real>& k, const ContactHistory<Real>& h) const {
        return Real(0.5) * (k.normal * h.overlap * h.overlap + twice_spring_energy(h.shear, k.shear) + twice_spring_energy(h.bending + h.twisting, k.rolling));
    }

    // The longest step to take whatever the contacts, s: none need be set, since each has its stiffness from the first touch.
    Coordinate longest_step(Coordinate) const { return infinity<Coordinate>(); }
};

}  // namespace graincal
