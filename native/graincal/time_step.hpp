// The critical time step from the diagonal of each particle's stiffness.
#pragma once

#include "arithmetic.hpp"

namespace graincal {

struct TimeStepper {
    Coordinate safety = 0.8;
    Coordinate root = square_root(2.0);           // dt_critical = sqrt(2 m / K) in terms of the diagonal
    Coordinate growth = 1.05;                     // at most this factor a step; falls at once
    Coordinate longest = infinity<Coordinate>();  // s, whatever the contacts say
    // Most steps between two estimates. The stiffness that bounds the step changes slowly against it: while it does not, by more than `unsteady` from one
    // estimate to the next, every step is estimated, and then fewer and fewer. What comes in between is held by the safety factor.
    Index longest_wait = 16;
    Coordinate unsteady = 0.01;

    bool due(long long step) const { return step >= next_estimate; }

    // The time step after an estimate at this step, of the largest squared frequency of a particle, 1/s^2.
    Coordinate next(Coordinate dt, Coordinate squared_frequency, long long step) {
        Coordinate taken = dt;
        const bool known = started;
        if (squared_frequency > 0) {
            const Coordinate critical = safety * root / square_root(squared_frequency);
            // The first estimate is taken whole: what came before was no estimate.
            Coordinate limit = started ? dt : critical;
            for (Index waited = 0; waited < wait; ++waited) limit *= growth;
            taken = minimum(minimum(critical, limit), longest);
            started = true;
        }
        const bool steady = known && absolute(taken - dt) <= unsteady * dt;
        wait = steady ? minimum(2 * wait, longest_wait) : 1;
        next_estimate = step + wait;
        return taken;
    }

    bool started = false;
    Index wait = 1;
    long long next_estimate = 0;
};

}  // namespace graincal
