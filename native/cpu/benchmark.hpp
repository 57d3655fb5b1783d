// Where the time of a run goes, and what the machine could do in it: for benchmarks/engine.py alone. Compiled like the step, once per instruction set.
#pragma once

#include "graincal/stress_path.hpp"

namespace graincal {

using Clock = double (*)();  // s

enum Pass { outer_list, near_list, forces, stiffness, stage, motion, pass_count };

// `follow` (graincal/stress_path.hpp), pass by pass; the time of each is added to its seconds.
template <class Team, class Real, class Law>
Status follow_timed(const Team& team, Simulation<Real, Law>& sim, const Stage* stages, Index stage_count, Progress& progress, const Rest& rest,
                    Record* records, long long steps, Clock now, double* seconds) {
    double before = now();
    const auto spent = [&](Pass pass) {
        const double after = now();
        seconds[pass] += after - before;
        before = after;
    };
    for (long long step = 0; step < steps; ++step) {
        const Index outer_rebuilds = sim.neighbours.outer_rebuilds;
        const Status listed = as_simulation_status(update_neighbours(team, sim.neighbours, sim.particles, sim.cell));
        spent(sim.neighbours.outer_rebuilds > outer_rebuilds ? outer_list : near_list);
        if (listed != Status::running) return listed;
        const Vec3<Coordinate> virial = find_pair_forces(team, sim.law, sim.cell, sim.particles, sim.neighbours, sim.time_step);
        sim.stress = (1 / sim.cell.volume()) * virial;
        spent(forces);
        choose_time_step(team, sim);
        spent(stiffness);
        follow_mean_stress(stages[progress.stage], sim);
        if (stage_is_over(team, stages[progress.stage], sim, progress, rest, records)) {
            if (++progress.stage == stage_count) return Status::finished;
            enter_stage(stages[progress.stage], sim, progress, rest);
        }
        drive_cell(sim);
        spent(stage);
        const Status moved = move(team, sim);
        spent(motion);
        if (moved != Status::running) return moved;
    }
    return Status::running;
}

#if defined(__AVX512F__)
constexpr Index vector_bytes = 64;
#elif defined(__AVX__)
constexpr Index vector_bytes = 32;
#else
constexpr Index vector_bytes = 16;
#endif

// Multiplications and additions without end, in the widest vectors and as many chains as hide their latency. Never contracted, as in the step. Returns
// how many operations were done.
template <class Real> double multiply_and_add(long long rounds) {
    typedef Real Vector __attribute__((vector_size(vector_bytes)));
    constexpr Index chains = 12, lanes = vector_bytes / sizeof(Real);
    Vector chain[chains], factor, term;
    for (Index l = 0; l < lanes; ++l) factor[l] = Real(0.999), term[l] = Real(0.001);
    for (Index c = 0; c < chains; ++c) chain[c] = term * Real(c);
    for (long long round = 0; round < rounds; ++round) {
#pragma GCC unroll 12
        for (Index c = 0; c < chains; ++c) chain[c] = chain[c] * factor + term;
    }
    for (Index c = 1; c < chains; ++c) chain[0] += chain[c];
    volatile Real kept = chain[0][0];  // or nothing of it would be computed
    (void)kept;
    return 2.0 * chains * lanes * double(rounds);
}

// STREAM's triad, a = b + s c: three numbers move for two operations.
inline void triad(double* a, const double* b, const double* c, long long count) {
#pragma GCC ivdep
    for (long long i = 0; i < count; ++i) a[i] = b[i] + 3.0 * c[i];
}

}  // namespace graincal
