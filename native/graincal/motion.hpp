// Leapfrog motion of the fluctuation about the cell's deformation, with Cundall's damping.
#pragma once

#include "cell.hpp"
#include "particles.hpp"

namespace graincal {

// a (1 - zeta sign(a w)) per component, w the velocity half a step on: forces that drive the motion are weakened, those that brake it strengthened.
template <class Real> Vec3<Real> damped(const Vec3<Real>& acceleration, const Vec3<Real>& velocity, Real damping, Real dt) {
    const auto component = [=](Real a, Real v) {
        const Real power = a * (v + Real(0.5) * dt * a);
        const Real weakened = power > Real(0) ? Real(1) - damping : Real(1);
        return a * (power < Real(0) ? Real(1) + damping : weakened);
    };
    return {component(acceleration.x, velocity.x), component(acceleration.y, velocity.y), component(acceleration.z, velocity.z)};
}

// The velocity that damping opposes: the fluctuation.
template <class Real> struct OwnFluctuation {
    Vec3<Real> operator()(Index, const Vec3<Real>& u) const { return u; }
};

// Moves the cell and the particles through dt and returns the largest fluctuation velocity, m/s. `opposed(i, u)` is the velocity that the damping
// of translation opposes.
template <class Team, class Real, class Opposed = OwnFluctuation<Real>>
Real advance_motion(const Team& team, Particles<Real>& particles, Cell& cell, Coordinate damping, Coordinate time_step, Opposed opposed = {}) {
    cell.advance(time_step);
    const Mat3<Coordinate> to_fractional = time_step * inverse(cell.edges);
    const Real dt = Real(time_step), zeta = Real(damping);
    const Particles<Real> p = particles;
    team.each(p.count, [=](Index i) {
        const Load<Real>& load = p.load[i];
        Vec3<Real> u = p.velocity[i], w = p.spin[i];
        u += dt * damped(p.inverse_mass[i] * load.force, opposed(i, u), zeta, dt);
        w += dt * damped(p.inverse_inertia[i] * load.torque, w, zeta, dt);
        p.velocity.set(i, u);
        p.spin.set(i, w);
        p.fractional.set(i, p.fractional[i] + to_fractional * as<Coordinate>(u));
    });
    team.sync();
    const Real squared = team.largest(p.count, [=](Index i) {
        const Vec3<Real> u = p.velocity[i];
        const Real speed = dot(u, u);
        // A maximum passes over what is not a number; an infinite speed it does not.
        return speed >= Real(0) ? speed : infinity<Real>();
    });
    return square_root(squared);
}

}  // namespace graincal
