// The servo drives the cell's velocity gradient, axis by axis, to a stress or to a strain. Source: YADE's PeriTriaxController with dynCell.
#pragma once

#include "vec3.hpp"

namespace graincal {

enum class Control { strain, stress };

template <class Real> struct AxisGoal {
    Control control = Control::strain;
    Real target = 0;        // logarithmic strain, or stress in Pa; compression positive
    Real largest_rate = 0;  // 1/s
};

template <class Real> struct Servo {
    AxisGoal<Real> axis[3];
    Real inertia = 1;  // of the cell against a stress difference, kg/m
    Real stress_tolerance = Real(1e-3);  // relative to the target
    Real strain_tolerance = Real(1e-6);

    static constexpr Real damping = Real(0.25);

    // The next rate of extension of an axis, 1/s.
    Real rate(Index a, Real present_rate, Real stress, Real strain, Real dt) const {
        const AxisGoal<Real>& goal = axis[a];
        if (goal.control == Control::strain) return clamp((strain - goal.target) / dt, goal.largest_rate);
        const Real excess = stress - goal.target;
        return clamp(present_rate + (Real(1) - damping * sign(present_rate * excess)) * dt * excess / inertia, goal.largest_rate);
    }

    bool reached(Index a, Real stress, Real strain) const {
        const AxisGoal<Real>& goal = axis[a];
        if (goal.control == Control::strain) return absolute(strain - goal.target) <= strain_tolerance;
        return absolute(stress - goal.target) <= stress_tolerance * absolute(goal.target);
    }
};

// The cell's inertia M = c rho V^(2/3), rho with density scaling. YADE takes the sum of the particle masses in kg, a figure that follows the
// sample's size; c makes the two equal on the 2000-particle packing of Hartmann, Cheng, Thornton (2022).
template <class Real> constexpr Real servo_inertia_factor = Real(0.037496272819642594);

}  // namespace graincal
