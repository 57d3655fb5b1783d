// A stress path is a sequence of stages; each drives every axis to a stress or a strain and waits until the packing is at rest there.
// The drained triaxial test of Hartmann, Cheng, Thornton (2022) is one such sequence.
#pragma once

#include "simulation.hpp"

namespace graincal {

struct Stage {
    AxisGoal axis[3];
    bool record = false;         // relax with the heavier damping, then write the state down
    bool strain_origin = false;  // strains count from the end of this stage
    bool mean_stress = false;    // stress targets are of the mean stress, which the axes under stress control keep together
};

struct Rest {
    Coordinate unbalanced_force = 1e-3;
    Coordinate loading_damping = 0.2;
    Coordinate settling_damping = 0.2;  // once every axis has arrived
    Coordinate relaxing_damping = 0.9;
    long long step_limit = 25000;     // a state not at rest after so many steps, or
    Coordinate loading_multiple = 5;  // so many times the steps of its loading if that is more, is taken as it is and flagged
    Coordinate ramp = 0;              // the share of a stage's strain over which the rate rises to its largest, and over which it falls again; 0 where it jumps
};

// One recorded state.
struct Record {
    Mat3<Coordinate> edges, stress;
    Vec3<Coordinate> strain;
    Fabric fabric;
    Coordinate unbalanced_force;
    long long steps;
    bool flagged;
};

// Where a run along a path stands between two steps: with the simulation, all that is needed to go on.
struct Progress {
    Index stage = 0;
    bool relaxing = false;
    long long stage_start = 0;                // steps
    int side[3] = {0, 0, 0};                  // of its target on which each axis began: -1 below, 1 above, 0 not looked at yet
    bool arrived[3] = {false, false, false};  // whether each axis has met its target once, or crossed it
    long long loading_steps = -1;             // until all had; -1 before
    Index records = 0;
    bool consolidation_flagged = false;  // a stage without a record was not at rest within its limit
};

template <class Team, class Real, class Law> Record record_state(const Team& team, const Simulation<Real, Law>& sim, Coordinate unbalanced, bool flagged) {
    Record record;
    record.edges = sim.cell.edges;
    record.stress = stress_tensor(team, sim.law, sim.cell, sim.particles, sim.neighbours.slots);
    record.strain = {sim.cell.strain(0), sim.cell.strain(1), sim.cell.strain(2)};
    record.fabric = fabric(team, sim.law, sim.particles, sim.neighbours, record.stress);
    record.unbalanced_force = unbalanced;
    record.steps = sim.steps;
    record.flagged = flagged;
    return record;
}

// Where a stage holds the mean stress, the axes under stress control share what the others leave of it at this moment.
template <class Real, class Law> void follow_mean_stress(const Stage& stage, Simulation<Real, Law>& sim) {
    if (!stage.mean_stress) return;
    Coordinate others = 0, sharing = 0;
    for (Index axis = 0; axis < 3; ++axis) {
        if (stage.axis[axis].control == Control::stress)
            sharing += 1;
        else
            others += sim.stress[axis];
    }
    for (Index axis = 0; axis < 3; ++axis)
        if (stage.axis[axis].control == Control::stress) sim.servo.axis[axis].target = (3 * stage.axis[axis].target - others) / sharing;
}

// Rises from zero to the largest rate r over the share s of the strain d: a = r^2 / (2 s d).
template <class Real, class Law> void ramp_strains(Simulation<Real, Law>& sim, Coordinate ramp) {
    for (Index axis = 0; axis < 3; ++axis) {
        AxisGoal& goal = sim.servo.axis[axis];
        const Coordinate way = absolute(goal.target - sim.cell.strain(axis));
        const bool ramped = goal.control == Control::strain && ramp > 0 && way > sim.servo.strain_tolerance;
        goal.acceleration = ramped ? goal.largest_rate * goal.largest_rate / (2 * ramp * way) : 0;
    }
}

template <class Real, class Law> void enter_stage(const Stage& stage, Simulation<Real, Law>& sim, Progress& progress, const Rest& rest) {
    for (Index axis = 0; axis < 3; ++axis) sim.servo.axis[axis] = stage.axis[axis];
    ramp_strains(sim, rest.ramp);
    follow_mean_stress(stage, sim);
    set_damping(sim, rest.loading_damping);
    progress.relaxing = false;
    progress.stage_start = sim.steps;
    progress.loading_steps = -1;
    for (Index axis = 0; axis < 3; ++axis) progress.side[axis] = 0, progress.arrived[axis] = false;
}

// Whether every axis meets its target at this moment. Loading is over once each has done so, at whatever moment of its own: a stress that rings about
// its target may never meet it together with the others.
template <class Real, class Law> bool targets_met(const Simulation<Real, Law>& sim, Progress& progress) {
    bool met = true, loaded = true;
    for (Index axis = 0; axis < 3; ++axis) {
        const Coordinate stress = sim.stress[axis], strain = sim.cell.strain(axis);
        const AxisGoal& goal = sim.servo.axis[axis];
        const int side = int(sign((goal.control == Control::stress ? stress : strain) - goal.target));
        if (progress.side[axis] == 0) progress.side[axis] = side;
        const bool reached = sim.servo.reached(axis, stress, strain);
        progress.arrived[axis] = progress.arrived[axis] || reached || side != progress.side[axis];
        met = met && reached;
        loaded = loaded && progress.arrived[axis];
    }
    if (loaded && progress.loading_steps < 0) progress.loading_steps = sim.steps - progress.stage_start;
    return met;
}

// Looks at the state after a force pass: true when the stage is over.
template <class Team, class Real, class Law>
bool stage_is_over(const Team& team, const Stage& stage, Simulation<Real, Law>& sim, Progress& progress, const Rest& rest, Record* records) {
    const bool reached = targets_met(sim, progress);
    if (progress.loading_steps >= 0 && !progress.relaxing) set_damping(sim, rest.settling_damping);
    const long long steps = sim.steps - progress.stage_start;
    const bool out_of_patience =
        progress.loading_steps >= 0 && steps > rest.step_limit && Coordinate(steps) > rest.loading_multiple * Coordinate(progress.loading_steps);
    if (!reached && !out_of_patience) return false;

    const Coordinate unbalanced = unbalanced_force(team, sim.law, sim.particles, sim.neighbours.slots);
    const bool at_rest = reached && unbalanced < rest.unbalanced_force;
    if (!at_rest && !out_of_patience) return false;
    if (stage.record && at_rest && !progress.relaxing) {
        progress.relaxing = true;
        set_damping(sim, rest.relaxing_damping);
        return false;
    }
    if (stage.record) {
        const Record record = record_state(team, sim, unbalanced, !at_rest);
        team.once([&] { records[progress.records] = record; });
        ++progress.records;
    } else {
        progress.consolidation_flagged = progress.consolidation_flagged || !at_rest;
    }
    if (stage.strain_origin) {
        sim.cell.initial_edges = sim.cell.edges;
        sim.cell.velocity_gradient = {};
    }
    return true;
}

// Advances at most `steps` steps along the path. Anything but `running` ends the call early; where the neighbour lists ask for an order or for room the
// simulation is untouched, and goes on once it has them.
template <class Team, class Real, class Law, class Watch = Unwatched>
Status follow(const Team& team, Simulation<Real, Law>& sim, const Stage* stages, Index stage_count, Progress& progress, const Rest& rest, Record* records,
              long long steps, Watch&& watch = Unwatched{}) {
    for (long long step = 0; step < steps; ++step) {
        if (const Status status = find_forces(team, sim, watch); status != Status::running) return status;
        choose_time_step(team, sim);
        watch(Pass::stiffness);
        follow_mean_stress(stages[progress.stage], sim);
        if (stage_is_over(team, stages[progress.stage], sim, progress, rest, records)) {
            if (++progress.stage == stage_count) return Status::finished;
            enter_stage(stages[progress.stage], sim, progress, rest);
        }
        drive_cell(sim);
        watch(Pass::stage);
        const Status moved = move(team, sim);
        watch(Pass::motion);
        if (moved != Status::running) return moved;
    }
    return Status::running;
}

}  // namespace graincal
