// What a run may do to take fewer steps for the same answer; by default nothing, which is the protocol of Hartmann, Cheng, Thornton (2022).
#pragma once

#include "stress_path.hpp"

namespace graincal {

struct Economy {
    Coordinate strain_ramp = Rest{}.ramp;
    bool shared_bound = TimeStepper{}.shared;
    // Particles' masses go with this power of the radius, at the mass of the whole that the density gives. Stiffness goes with about the radius: at 1 the
    // small particles no longer limit the time step.
    Coordinate mass_exponent = 3;
    Coordinate settling_damping = Rest{}.settling_damping;
    Coordinate inertia_factor = 1;  // on the moments of inertia of the spheres

    Rest rest() const {
        Rest rest;
        rest.ramp = strain_ramp;
        rest.settling_damping = settling_damping;
        return rest;
    }
    template <class Real, class Law> void apply(Simulation<Real, Law>& sim) const { sim.time_stepper.shared = shared_bound; }
};

}  // namespace graincal
