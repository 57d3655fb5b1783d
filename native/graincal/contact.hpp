// What a contact is, and what every contact law here shares: sliding, rolling and twisting resistance in increments.
// Source: Hartmann, Cheng, Thornton (2022), Table 1 and Eq. 1; order of operations as in YADE's Law2_ScGeom6D_CohFrictPhys_CohesionMoment.
#pragma once

#include "vec3.hpp"

namespace graincal {

// Two touching spheres at the present positions.
template <class Real> struct TouchingPair {
    Real radius1, radius2;
    Real overlap;                  // r1 + r2 - d, negative for a pair that does not touch
    Real stretch;                  // (r1 + r2) / d
    Vec3<Real> normal;             // unit vector from 1 to 2
    Vec3<Real> relative_velocity;  // of centre 2 against centre 1, through the boundary where the pair crosses it
    Vec3<Real> spin1, spin2;
};

// What a contact remembers. A pair that does not touch has a negative overlap and no forces or moments: what it is, once it touches, starts from nothing.
template <class Real> struct ContactHistory {
    Real overlap = Real(-1);
    Vec3<Real> normal;
    Vec3<Real> shear;     // tangential force on 2
    Vec3<Real> bending;   // moment on 2 across the normal
    Vec3<Real> twisting;  // moment on 2 along the normal

    // As it is for the pair (2, 1).
    ContactHistory reversed() const { return {overlap, -normal, -shear, -bending, -twisting}; }
};

template <class Real> struct ContactStiffness {
    Real normal, shear, rolling;  // N/m, N/m, N m/rad
};

// Of a spring that holds this force or moment, J.
template <class Real> Real twice_spring_energy(const Vec3<Real>& held, Real stiffness) { return stiffness > Real(0) ? dot(held, held) / stiffness : Real(0); }

// Written without branches, so that a loop over pairs becomes vector code. Squares of what is below 1e-23 vanish in float32, and forces
// (N) and moments (N m) as small as that are not capped: they are nothing beside those of grains.
template <class Real> Vec3<Real> capped(const Vec3<Real>& v, Real limit) {
    const Real squared = dot(v, v);
    const Real shrunk = limit / square_root(squared);
    return (squared > limit * limit ? shrunk : Real(1)) * v;
}

// Carries the stored shear force and moments to the new normal, adds this step's increments and caps each. The caps go with the normal force, which is
// zero without contact: what does not touch is left with nothing, and so a new contact starts from nothing whatever its old normal.
template <class Real>
ContactHistory<Real> advance_resistances(const TouchingPair<Real>& pair, const ContactStiffness<Real>& stiffness, Real normal_force, Real friction,
                                         Real rolling_strength, Real dt, const ContactHistory<Real>& before) {
    const Vec3<Real>& n = pair.normal;
    const Vec3<Real> turn = cross(before.normal, n);
    const Vec3<Real> spin_about_normal = (Real(0.5) * dt * dot(before.normal, pair.spin1 + pair.spin2)) * before.normal;
    const auto carried = [&](Vec3<Real> v) {
        v -= cross(v, turn);
        v -= cross(v, spin_about_normal);
        return v;
    };

    // The full radii as arms and the stretched translation keep a contact from ratcheting (no force gained in a closed loop).
    const Vec3<Real> slip = pair.stretch * pair.relative_velocity - cross(pair.radius2 * pair.spin2 + pair.radius1 * pair.spin1, n);
    const Vec3<Real> relative_spin = pair.spin2 - pair.spin1;
    const Vec3<Real> twist = dot(relative_spin, n) * n;

    const Real moment_limit = rolling_strength * normal_force * minimum(pair.radius1, pair.radius2);
    return {pair.overlap, n, capped(carried(before.shear) - (stiffness.shear * dt) * (slip - dot(slip, n) * n), friction * normal_force),
            capped(carried(before.bending) - (stiffness.rolling * dt) * (relative_spin - twist), moment_limit),
            capped(carried(before.twisting) - (stiffness.rolling * dt) * twist, moment_limit)};
}

}  // namespace graincal
