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
    Real* mass;

    void lay_out(Arena& arena, Index n) {
        count = n;
        fractional = arena.take_vectors<Real>(n);
        velocity = arena.take_vectors<Real>(n);
        spin = arena.take_vectors<Real>(n);
        force = arena.take_vectors<Real>(n);
        torque = arena.take_vectors<Real>(n);
        radius = arena.take<Real>(n);
        mass = arena.take<Real>(n);
    }
    Real inertia(Index i) const { return Real(0.4) * mass[i] * radius[i] * radius[i]; }
};

}  // namespace graincal
