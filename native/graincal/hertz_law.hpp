// Hertz-Mindlin: the contact of elastic spheres, with the sliding, rolling and twisting resistance of the linear law.
// Sources: Hertz (1882) for the normal force; Mindlin (1949) for the tangential stiffness without slip; bending and twisting as Hartmann, Cheng,
// Thornton (2022), Table 1, on the tangential stiffness of the moment.
//
// A tangential stiffness that falls with the overlap would leave a stored force with more energy than was put into it. Where the overlap falls, what is
// stored is therefore scaled down with the stiffness, as if the springs kept their stretch; where it grows, the forces are kept. Either way energy is
// lost, never gained. Source: Thornton, Cummins, Cleary (2013), Powder Technology 233; LAMMPS has it as `mindlin_rescale/force`, YADE does not have it.
#pragma once

#include "contact.hpp"

namespace graincal {

template <class Real> struct HertzLaw {
    Real modulus;            // E, Young's modulus of the grains, Pa
    Real poisson_ratio;      // nu of the grains
    Real friction;           // tan(phi)
    Real rolling_stiffness;  // beta_m
    Real rolling_strength;   // eta_m

    template <class Other> HertzLaw<Other> in_precision() const {
        return {Other(modulus), Other(poisson_ratio), Other(friction), Other(rolling_stiffness), Other(rolling_strength)};
    }

    // Tangents: dFn / dun = 2 E* a and 8 G* a, with the radius of the contact a = sqrt(r* un), E* = E / (2 (1 - nu^2)), G* = E / (4 (1 + nu) (2 - nu)).
    ContactStiffness<Real> stiffness(const TouchingPair<Real>& pair) const {
        const Real product = pair.radius1 * pair.radius2;
        const Real contact_radius = square_root(product / (pair.radius1 + pair.radius2) * maximum(pair.overlap, Real(0)));
        const Real normal = modulus / (Real(1) - poisson_ratio * poisson_ratio) * contact_radius;
        const Real shear = Real(2) * modulus / ((Real(1) + poisson_ratio) * (Real(2) - poisson_ratio)) * contact_radius;
        return {normal, shear, rolling_stiffness * product * shear};
    }

    // 4/3 E* sqrt(r*) un^(3/2); the stiffness is zero without contact.
    Real normal_force(const TouchingPair<Real>& pair, const ContactStiffness<Real>& k) const { return Real(2) / Real(3) * k.normal * pair.overlap; }

    // The contact's memory one step on.
    ContactHistory<Real> advance(const TouchingPair<Real>& pair, const ContactStiffness<Real>& k, Real normal_force, Real dt,
                                 const ContactHistory<Real>& before) const {
        // All three stiffnesses go with the root of the overlap.
        const bool unloads = before.overlap > Real(0) && pair.overlap < before.overlap;
        const Real left = square_root(maximum(pair.overlap, Real(0)) / (unloads ? before.overlap : Real(1)));
        const Real share = unloads ? left : Real(1);
        return advance_resistances(pair, k, normal_force, friction, rolling_strength, dt,
                                   {before.overlap, before.normal, share * before.shear, share * before.bending, share * before.twisting});
    }

    // Energy held in a contact, J: 2/5 Fn un along the normal, springs of the present stiffness for the rest.
    Real elastic_energy(const ContactStiffness<Real>& k, const ContactHistory<Real>& h) const {
        const Real normal = Real(4) / Real(15) * k.normal * h.overlap * h.overlap;
        return normal + Real(0.5) * (twice_spring_energy(h.shear, k.shear) + twice_spring_energy(h.bending + h.twisting, k.rolling));
    }

    // A contact that has only begun has almost no stiffness, and the critical step it asks for says nothing of the next overlap. The bound is that of
    // contacts with overlaps of some 1e-4 of a radius, which takes less than a millionth of E as pressure.
    Coordinate longest_step(Coordinate wave_time) const { return 20 * wave_time; }
};

}  // namespace graincal
