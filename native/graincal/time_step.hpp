// The critical time step from the diagonal of each particle's stiffness.
#pragma once

#include "forces.hpp"

namespace graincal {

// The largest of max(K/m, R/I) over particles with contacts, 1/s^2; zero where nothing touches. K_a = sum (kn - ks) n_a^2 + ks and
// R_a = sum ks r^2 (1 - n_a^2) + km per axis a, as YADE's GlobalStiffnessTimeStepper.
template <class Team, class Real>
Real largest_squared_frequency(const Team& team, const Particles<Real>& particles, const Neighbours<Real>& list, const PairForces<Real>& pairs) {
    return team.largest(particles.count, [&](Index i) {
        Vec3<Real> translation, shear_across;
        Real rolling = 0;
        each_slot_of(i, list, [&](Index slot, bool) {
            if (!list.slots.touching(slot)) return;
            const ContactStiffness<Real> k = pairs.stiffness(slot);
            const Vec3<Real> n = list.slots.normal[slot];
            const Vec3<Real> squared = componentwise(n, n);
            translation += (k.normal - k.shear) * squared + Vec3<Real>{k.shear, k.shear, k.shear};
            shear_across += k.shear * (Vec3<Real>{1, 1, 1} - squared);
            rolling += k.rolling;
        });
        const Real r = particles.radius[i];
        const Real rotation = r * r * largest(shear_across) + rolling;
        return maximum(largest(translation) / particles.mass[i], rotation / particles.inertia(i));
    });
}

template <class Real> struct TimeStepper {
    Real safety = Real(0.8);
    Real root = square_root(Real(2));  // dt_critical = sqrt(2 m / K) in terms of the diagonal
    Real growth = Real(1.05);          // at most this factor a step; falls at once
    bool started = false;              // the first estimate is taken whole: what came before was no estimate

    Real next(Real dt, Real squared_frequency) {
        if (!(squared_frequency > Real(0))) return dt;
        const Real critical = safety * root / square_root(squared_frequency);
        const Real limit = started ? growth * dt : critical;
        started = true;
        return minimum(critical, limit);
    }
};

}  // namespace graincal
