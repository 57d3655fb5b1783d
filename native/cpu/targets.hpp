// The step, compiled once per instruction set; the best that the machine can run is chosen when the module is loaded.
#pragma once

namespace graincal {

// What `follow` (graincal/stress_path.hpp) takes, without types: each instruction set has the types in a namespace of its own, all laid out alike.
struct PathCall {
    int engine;  // its place among the compiled ones (graincal/engines.hpp), which gives the types of the rest
    void* simulation;
    const void* stages;
    int stage_count;
    void* progress;
    const void* rest;
    void* records;
    long long steps;
};

// What `run` (graincal/simulation.hpp) takes.
struct RunCall {
    int engine;
    void* simulation;
    long long last_step;
};

// What benchmarks/engine.py asks (cpu/benchmark.hpp).
struct BenchmarkCalls {
    int (*follow_timed)(const PathCall&, double (*now)(), double* seconds);
    double (*multiply_and_add_float64)(long long rounds);
    double (*multiply_and_add_float32)(long long rounds);
    void (*triad)(double* a, const double* b, const double* c, long long count);
};

struct Target {
    const char* name;
    bool (*runs_here)();
    int (*follow)(const PathCall&);  // a Status
    int (*run)(const RunCall&);      // a Status
    BenchmarkCalls benchmark;
};

// From the plainest to the best, as compiled in; ends with a null name.
extern const Target targets[];

inline const Target& best_target() {
    const Target* best = targets;
    for (const Target* target = targets; target->name; ++target)
        if (target->runs_here()) best = target;
    return *best;
}

}  // namespace graincal
