// The critical time step from a bound on the frequencies of the packing.
#pragma once

#include "arithmetic.hpp"

namespace graincal {

struct TimeStepper {
    Coordinate safety = 0.8;
    // Whether the bound looks at both particles of a contact (share_stiffness in forces.hpp), and at the damping. It is then 2 to 10 % below the step at which
    // packings gain energy; the bound on each particle alone is 21 to 29 % below it before its safety factor.
    bool shared = false;
    // Two grains that roll on each other by ks alone move up to 1.18 times as fast as the bound, which takes translation and rotation one at a time.
    Coordinate shared_safety = 0.84;
    Coordinate root = square_root(2.0);           // dt_critical = sqrt(2 m / K) in terms of the diagonal
    Coordinate growth = 1.05;                     // at most this factor for each step since the latest estimate; falls at once
    Coordinate longest = infinity<Coordinate>();  // s, whatever the contacts say
    // Most steps between two estimates. The stiffness that bounds the step changes slowly against it: while it does not, by more than `unsteady` from one
    // estimate to the next, every step is estimated, and then fewer and fewer. A bound that is cheap to find is looked at every step: where it has risen since
    // the latest estimate, as where grains gather, the next is due at once. The bound is of the stiffest grain alone: another's rise below it goes unseen for
    // as long, and is held by the safety factor.
    Index longest_wait = 16;
    Coordinate unsteady = 0.01;

    bool due(long long step, Coordinate bound) const { return step >= next_estimate || bound > (1 + unsteady) * bound_then; }
    void look_again(long long step) { next_estimate = step, wait = 1; }

    // Cundall's damping strengthens forces that brake to 1 + zeta times what they are, and a leapfrog under it decays up to w dt = 2 / sqrt(1 + zeta). The
    // bound on each particle alone leaves that to its safety factor, as YADE's does.
    Coordinate strengthened(Coordinate damping) const { return shared ? 1 + damping : 1; }

    // The time step after an estimate at this step, of the largest squared frequency of a particle, 1/s^2, which is at most `bound`.
    Coordinate next(Coordinate dt, Coordinate squared_frequency, Coordinate bound, long long step) {
        Coordinate taken = dt;
        const bool known = started;
        if (squared_frequency > 0) {
            const Coordinate critical = (shared ? shared_safety : safety) * root / square_root(squared_frequency);
            // The first estimate is taken whole: what came before was no estimate.
            Coordinate limit = started ? dt : critical;
            for (long long passed = latest_estimate; passed < step; ++passed) limit *= growth;
            taken = minimum(minimum(critical, limit), longest);
            started = true;
        }
        const bool steady = known && absolute(taken - dt) <= unsteady * dt;
        wait = steady ? minimum(2 * wait, longest_wait) : 1;
        latest_estimate = step;
        next_estimate = step + wait;
        bound_then = bound;
        return taken;
    }

    bool started = false;
    Index wait = 1;
    long long latest_estimate = 0, next_estimate = 0;
    Coordinate bound_then = 0;
};

}  // namespace graincal
