// The servo drives the cell's velocity gradient, axis by axis, to a stress or to a strain. Source: YADE's PeriTriaxController with dynCell.
#pragma once

#include "vec3.hpp"

namespace graincal {

enum class Control { strain, stress };

struct AxisGoal {
    Control control = Control::strain;
    Coordinate target = 0;        // logarithmic strain, or stress in Pa; compression positive
    Coordinate largest_rate = 0;  // 1/s
    Coordinate acceleration = 0;  // of the rate towards a strain, and of its fall before the strain is reached, 1/s^2; 0 where the rate jumps
};

struct Servo {
    AxisGoal axis[3];
    Coordinate inertia = 1;              // of the cell against a stress difference, kg/m
    Coordinate stress_tolerance = 1e-3;  // relative to the target
    Coordinate strain_tolerance = 1e-6;

    static constexpr Coordinate damping = 0.25;

    // The next rate of extension of an axis, 1/s.
    Coordinate rate(Index a, Coordinate present_rate, Coordinate stress, Coordinate strain, Coordinate dt) const {
        const AxisGoal& goal = axis[a];
        if (goal.control == Control::strain) {
            if (goal.acceleration > 0) return ramped_rate(goal, present_rate, strain - goal.target, dt);
            return clamp((strain - goal.target) / dt, goal.largest_rate);
        }
        const Coordinate excess = stress - goal.target;
        return clamp(present_rate + (1 - damping * sign(present_rate * excess)) * dt * excess / inertia, goal.largest_rate);
    }

    // Towards what is left at no more than the rate that still comes to a stop there: v dt + v^2 / 2a = what is left. Close to the target that is the one
    // step that remains.
    static Coordinate ramped_rate(const AxisGoal& goal, Coordinate present_rate, Coordinate left, Coordinate dt) {
        const Coordinate stopping = goal.acceleration * (square_root(dt * dt + 2 * absolute(left) / goal.acceleration) - dt);
        const Coordinate rising = sign(left) * present_rate + goal.acceleration * dt;
        return clamp(sign(left) * minimum(rising, stopping), goal.largest_rate);
    }

    bool reached(Index a, Coordinate stress, Coordinate strain) const {
        const AxisGoal& goal = axis[a];
        if (goal.control == Control::strain) return absolute(strain - goal.target) <= strain_tolerance;
        return absolute(stress - goal.target) <= stress_tolerance * absolute(goal.target);
    }
};

// The cell's inertia M = c rho V^(2/3), rho with density scaling. YADE takes the sum of the particle masses in kg, a figure that follows the
// sample's size; c makes the two equal on the 2000-particle packing of Hartmann, Cheng, Thornton (2022).
constexpr Coordinate servo_inertia_factor = 0.037496272819642594;

}  // namespace graincal
