// The kernel's entry: each block takes the next simulation of the queue and follows its stress path.
#include "block_team.hpp"
#include "graincal/stress_path.hpp"

namespace graincal {

using DeviceSimulation = Simulation<double, LinearLaw<double>>;

// One simulation of a batch, laid out in device memory by the host.
struct DeviceTask {
    DeviceSimulation simulation;
    Progress<double> progress;
    Rest<double> rest;
    const Stage<double>* stages;
    Index stage_count;
    Record<double>* records;
    Status status;
};

}  // namespace graincal

extern "C" __global__ void follow_stress_paths(graincal::DeviceTask* tasks, graincal::Index task_count, graincal::Index* next, long long steps) {
    using namespace graincal;
    __shared__ __align__(64) char scratch[BlockTeam::scratch_bytes];
    __shared__ Index taken;
    const BlockTeam team(scratch);
    for (;;) {
        if (threadIdx.x == 0) taken = atomicAdd(next, 1);
        team.sync();
        const Index mine = taken;
        team.sync();
        if (mine >= task_count) return;
        // Every thread advances its own copy of the scalars; the arrays they point to are the block's.
        DeviceTask task = tasks[mine];
        if (task.simulation.steps == 0) enter_stage(task.stages[0], task.simulation, task.progress, task.rest);
        task.status = follow(team, task.simulation, task.stages, task.stage_count, task.progress, task.rest, task.records, steps);
        team.sync();
        if (threadIdx.x == 0) tasks[mine] = task;
    }
}
