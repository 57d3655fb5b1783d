// The critical time step from the diagonal of each particle's stiffness.
#pragma once

#include "forces.hpp"

namespace graincal {

template <class Team, class Real> Real largest_squared_frequency(const Team& team, const Particles<Real>& particles) {
    return team.largest(particles.count, [&](Index i) { return particles.squared_frequency[i]; });
}

template <class Real> struct TimeStepper {
    Real safety = Real(0.8);
    Real root = square_root(Real(2));  // dt_critical = sqrt(2 m / K) in terms of the diagonal
    Real growth = Real(1.05);          // at most this factor a step; falls at once
    Real longest = infinity<Real>();   // s, whatever the contacts say
    bool started = false;              // the first estimate is taken whole: what came before was no estimate

    Real next(Real dt, Real squared_frequency) {
        if (!(squared_frequency > Real(0))) return dt;
        const Real critical = safety * root / square_root(squared_frequency);
        const Real limit = started ? growth * dt : critical;
        started = true;
        return minimum(minimum(critical, limit), longest);
    }
};

}  // namespace graincal
