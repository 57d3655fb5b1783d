// One simulation: its state, and the step that advances it.
#pragma once

#include "fabric.hpp"
#include "motion.hpp"
#include "servo.hpp"
#include "time_step.hpp"

namespace graincal {

enum class Status {
    running,
    finished,
    needs_sorting,
    needs_more_outer_pairs,
    needs_more_near_pairs,
    cell_too_small,
    diverged,
    out_of_steps,
    out_of_memory,
    stopped,
    cancelled
};

// The passes of a step. Whoever watches them is called at the end of each; by default nobody does.
enum class Pass { outer_list, near_list, forces, stiffness, stage, motion };
struct Unwatched {
    void operator()(Pass) const {}
};

template <class Real, class Law> struct Simulation {
    Particles<Real> particles;
    Neighbours<Real> neighbours;
    Cell cell;
    Law law;
    Servo servo;
    TimeStepper time_stepper;
    Coordinate time_step;  // s
    Coordinate time = 0;   // s
    Coordinate damping = 0.2;
    Coordinate smallest_radius;
    Vec3<Coordinate> stress;  // diagonal at the latest force pass, Pa, compression positive
    long long steps = 0;

    // `lands`: for a team that lands the terms of pairs.
    void lay_out(Arena& arena, Index n, Index outer_pairs, Index near_pairs, bool lands = false) {
        particles.lay_out(arena, n);
        neighbours.lay_out(arena, n, outer_pairs, near_pairs, lands);
    }
    // A simulation whose fastest particle crosses the smallest radius in a step has blown up: soft grains that are compressed fast come to a quarter.
    Coordinate speed_limit() const { return smallest_radius / time_step; }
};

inline Status as_simulation_status(NeighbourStatus status) {
    switch (status) {
        case NeighbourStatus::out_of_order:
            return Status::needs_sorting;
        case NeighbourStatus::outer_full:
            return Status::needs_more_outer_pairs;
        case NeighbourStatus::near_full:
            return Status::needs_more_near_pairs;
        case NeighbourStatus::cell_too_small:
            return Status::cell_too_small;
        case NeighbourStatus::out_of_place:
            return Status::diverged;
        default:
            return Status::running;
    }
}

// Forces, torques and stress at the present positions. The law's increments take the step that led here.
template <class Team, class Real, class Law, class Watch = Unwatched>
Status find_forces(const Team& team, Simulation<Real, Law>& sim, Watch&& watch = Unwatched{}) {
    const Index outer_rebuilds = sim.neighbours.outer_rebuilds;
    const Status status = as_simulation_status(update_neighbours(team, sim.neighbours, sim.particles, sim.cell));
    watch(sim.neighbours.outer_rebuilds > outer_rebuilds ? Pass::outer_list : Pass::near_list);
    if (status != Status::running) return status;
    const Vec3<Coordinate> virial = find_pair_forces(team, sim.law, sim.cell, sim.particles, sim.neighbours, sim.time_step);
    team.sync();
    sim.stress = (1 / sim.cell.volume()) * virial;
    watch(Pass::forces);
    return is_finite(sim.stress.x + sim.stress.y + sim.stress.z) ? Status::running : Status::diverged;
}

template <class Team, class Real, class Law> void choose_time_step(const Team& team, Simulation<Real, Law>& sim) {
    const Coordinate bound = bound_on_squared_frequency(team, sim.particles);
    if (!sim.time_stepper.due(sim.steps, bound)) return;
    stiffness_pass(team, sim.law, sim.particles, sim.neighbours);
    team.sync();
    if (sim.time_stepper.shared) share_stiffness(team, sim.law, sim.particles, sim.neighbours);
    const Coordinate squared_frequency = sim.time_stepper.strengthened(sim.damping) * largest_squared_frequency(team, sim.particles);
    sim.time_step = sim.time_stepper.next(sim.time_step, squared_frequency, bound, sim.steps);
}

// A damping that strengthens forces more takes a smaller time step from the next motion on.
template <class Real, class Law> void set_damping(Simulation<Real, Law>& sim, Coordinate damping) {
    TimeStepper& stepper = sim.time_stepper;
    const Coordinate before = stepper.strengthened(sim.damping), after = stepper.strengthened(damping);
    sim.damping = damping;
    if (before == after) return;
    sim.time_step *= minimum(Coordinate(1), square_root(before / after));
    stepper.look_again(sim.steps);
}

template <class Real, class Law> void drive_cell(Simulation<Real, Law>& sim) {
    for (Index axis = 0; axis < 3; ++axis) {
        Coordinate& rate = sim.cell.velocity_gradient(axis, axis);
        rate = sim.servo.rate(axis, rate, sim.stress[axis], sim.cell.strain(axis), sim.time_step);
    }
}

template <class Team, class Real, class Law, class Opposed = OwnFluctuation<Real>>
Status move(const Team& team, Simulation<Real, Law>& sim, Opposed opposed = {}) {
    const Coordinate fastest = advance_motion(team, sim.particles, sim.cell, sim.damping, sim.time_step, opposed);
    team.sync();
    sim.neighbours.travel += fastest * sim.time_step;
    sim.time += sim.time_step;
    ++sim.steps;
    return fastest < sim.speed_limit() ? Status::running : Status::diverged;
}

// Advances until `last_step` steps are done, the servo driving to the goals set. Where the neighbour lists ask for an order or for room the simulation is
// untouched, and goes on once it has them.
template <class Team, class Real, class Law> Status run(const Team& team, Simulation<Real, Law>& sim, long long last_step) {
    while (sim.steps < last_step) {
        if (const Status status = find_forces(team, sim); status != Status::running) return status;
        choose_time_step(team, sim);
        drive_cell(sim);
        if (const Status status = move(team, sim); status != Status::running) return status;
    }
    return Status::running;
}

}  // namespace graincal
