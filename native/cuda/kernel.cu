// The kernel's entries, one for each engine: each block takes the next simulation of the queue and follows its stress path.
#include "block_team.hpp"
#include "graincal/engines.hpp"

namespace graincal {

// One simulation of a batch, laid out in device memory by the host with room for the terms of its pairs to land.
template <class Engine> struct DeviceTask {
    typename Engine::State simulation;
    Progress progress;
    Rest rest;
    const Stage* stages;
    Index stage_count;
    Record* records;
    Status status;
};

template <class Engine> __device__ void follow_queue(DeviceTask<Engine>* tasks, Index task_count, Index* next, long long steps) {
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
        DeviceTask<Engine> task = tasks[mine];
        if (task.simulation.steps == 0) enter_stage(task.stages[0], task.simulation, task.progress, task.rest);
        task.status = follow(team, task.simulation, task.stages, task.stage_count, task.progress, task.rest, task.records, steps);
        team.sync();
        if (threadIdx.x == 0) tasks[mine] = task;
    }
}

template <class Real, template <class> class Law> using Tasks = DeviceTask<Engine<Real, Law>>*;

}  // namespace graincal

extern "C" __global__ void follow_stress_paths_linear_float64(graincal::Tasks<double, graincal::LinearLaw> tasks, graincal::Index task_count,
                                                              graincal::Index* next, long long steps) {
    graincal::follow_queue(tasks, task_count, next, steps);
}
extern "C" __global__ void follow_stress_paths_linear_float32(graincal::Tasks<float, graincal::LinearLaw> tasks, graincal::Index task_count,
                                                              graincal::Index* next, long long steps) {
    graincal::follow_queue(tasks, task_count, next, steps);
}
extern "C" __global__ void follow_stress_paths_hertz_float64(graincal::Tasks<double, graincal::HertzLaw> tasks, graincal::Index task_count,
                                                             graincal::Index* next, long long steps) {
    graincal::follow_queue(tasks, task_count, next, steps);
}
extern "C" __global__ void follow_stress_paths_hertz_float32(graincal::Tasks<float, graincal::HertzLaw> tasks, graincal::Index task_count,
                                                             graincal::Index* next, long long steps) {
    graincal::follow_queue(tasks, task_count, next, steps);
}
