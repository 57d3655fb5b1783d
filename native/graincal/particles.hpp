// The spheres: where they are, how they move, what acts on them.
#pragma once

#include "memory.hpp"

namespace graincal {

template <class Real> struct Particles {
    Index count = 0;
    Vec3Array<Real> fractional;  // s = H^-1 x, never wrapped: a difference is taken to its nearest image instead
    Vec3Array<Real> velocity;    // u = v - L x, the fluctuation about the cell's motion
    Vec3Array<Real> spin;
    Vec3Array<Real> force;
    Vec3Array<Real> torque;
    Real* radius;
    Real* inverse_mass;
    Real* inverse_inertia;    // of a sphere, 2/5 m r^2
    Real* squared_frequency;  // bound on the time step from the contacts' stiffness, 1/s^2; zero without contacts

    void lay_out(Arena& arena, Index n) {
        count = n;
        fractional = arena.take_vectors<Real>(n);
        velocity = arena.take_vectors<Real>(n);
        spin = arena.take_vectors<Real>(n);
        force = arena.take_vectors<Real>(n);
        torque = arena.take_vectors<Real>(n);
        radius = arena.take<Real>(n);
        inverse_mass = arena.take<Real>(n);
        inverse_inertia = arena.take<Real>(n);
        squared_frequency = arena.take<Real>(n);
    }
};

}  // namespace graincal
