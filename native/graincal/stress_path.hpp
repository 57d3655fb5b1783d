// A stress path is a sequence of stages; each drives every axis to a stress or a strain and waits until the packing is at rest there.
// The drained triaxial test of Hartmann, Cheng, Thornton (2022) is one such sequence.
#pragma once

#include "simulation.hpp"

namespace graincal {

template <class Real> struct Stage {
    AxisGoal<Real> axis[3];
    bool record = false;        // relax with the heavier damping, then write the state down
    bool strain_origin = false; // strains count from the end of this stage
};

template <class Real> struct Rest {
    Real unbalanced_force = Real(1e-3);
    Real loading_damping = Real(0.2);
    Real relaxing_damping = Real(0.9);
    long long step_limit = 25000;  // a state not at rest after so many steps, or
    Real loading_multiple = 5;     // so many times the steps of its loading if that is more, is taken as it is and flagged
};

// One recorded state.
template <class Real> struct Record {
    Mat3<Real> edges, stress;
    Vec3<Real> strain;
    Fabric<Real> fabric;
    Real unbalanced_force, time_step;
    long long steps;
    bool flagged;
};

// Where a run along a path stands between two steps: with the simulation, all that is needed to go on.
template <class Real> struct Progress {
    Index stage = 0;
    bool relaxing = false;
    long long stage_start = 0;    // steps
    long long loading_steps = -1; // until the targets were first met; -1 before
    Index records = 0;
    Index flagged = 0;            // states flagged, recorded or not
};

template <class Real> Real infinity() { return Real(1) / Real(0); }

template <class Team, class Real, class Law> Record<Real> record_state(const Team& team, const Simulation<Real, Law>& sim, Real unbalanced, bool flagged) {
    Record<Real> record;
    record.edges = sim.cell.edges;
    record.stress = stress_tensor(team, sim.cell, sim.particles, sim.neighbours.slots, sim.pair_forces);
    record.strain = {sim.cell.strain(0), sim.cell.strain(1), sim.cell.strain(2)};
    record.fabric = fabric(team, sim.particles, sim.neighbours, record.stress, sim.pair_forces);
    record.unbalanced_force = unbalanced;
    record.time_step = sim.time_step;
    record.steps = sim.steps;
    record.flagged = flagged;
    return record;
}

template <class Real, class Law> void enter_stage(const Stage<Real>& stage, Simulation<Real, Law>& sim, Progress<Real>& progress, const Rest<Real>& rest) {
    for (Index axis = 0; axis < 3; ++axis) sim.servo.axis[axis] = stage.axis[axis];
    sim.damping = rest.loading_damping;
    progress.relaxing = false;
    progress.stage_start = sim.steps;
    progress.loading_steps = -1;
}

// Looks at the state after a force pass: true when the stage is over.
template <class Team, class Real, class Law>
bool stage_is_over(const Team& team, const Stage<Real>& stage, Simulation<Real, Law>& sim, Progress<Real>& progress, const Rest<Real>& rest, Record<Real>* records) {
    bool reached = true;
    for (Index axis = 0; axis < 3; ++axis) reached = reached && sim.servo.reached(axis, sim.stress[axis], sim.cell.strain(axis));
    const long long steps = sim.steps - progress.stage_start;
    if (reached && progress.loading_steps < 0) progress.loading_steps = steps;
    const bool out_of_patience = progress.loading_steps >= 0 && steps > rest.step_limit && Real(steps) > rest.loading_multiple * Real(progress.loading_steps);
    if (!reached && !out_of_patience) return false;

    const Real unbalanced = unbalanced_force(team, sim.particles, sim.neighbours.slots, sim.pair_forces);
    const bool at_rest = reached && unbalanced < rest.unbalanced_force;
    if (!at_rest && !out_of_patience) return false;
    if (stage.record && at_rest && !progress.relaxing) {
        progress.relaxing = true;
        sim.damping = rest.relaxing_damping;
        return false;
    }
    progress.flagged += !at_rest;
    if (stage.record) records[progress.records++] = record_state(team, sim, unbalanced, !at_rest);
    if (stage.strain_origin) {
        sim.cell.initial_edges = sim.cell.edges;
        sim.cell.velocity_gradient = {};
    }
    return true;
}

// Advances at most `steps` steps along the path. Anything but `running` ends the call early; after a neighbour list was found full the
// simulation is untouched, and goes on once it has more room.
template <class Team, class Real, class Law>
Status follow(const Team& team, Simulation<Real, Law>& sim, const Stage<Real>* stages, Index stage_count, Progress<Real>& progress,
              const Rest<Real>& rest, Record<Real>* records, long long steps) {
    for (long long step = 0; step < steps; ++step) {
        if (const Status status = find_forces(team, sim); status != Status::running) return status;
        choose_time_step(team, sim);
        if (stage_is_over(team, stages[progress.stage], sim, progress, rest, records)) {
            if (++progress.stage == stage_count) return Status::finished;
            enter_stage(stages[progress.stage], sim, progress, rest);
        }
        drive_cell(sim);
        if (const Status status = move(team, sim); status != Status::running) return status;
    }
    return Status::running;
}

}  // namespace graincal
