// Compiled once per instruction set, which GRAINCAL_TARGET names. The physics headers include nothing but each other, so they can be taken whole into
// a namespace of their own: no two instruction sets ever share an inline function.
#include "targets.hpp"

namespace GRAINCAL_TARGET {
// clang-format off
#include "graincal/engines.hpp"
#include "cpu/serial_team.hpp"
#include "cpu/benchmark.hpp"
// clang-format on

int follow_path(const ::graincal::PathCall& call) {
    using namespace GRAINCAL_TARGET::graincal;
    return CompiledEngines::visit(call.engine, [&]<class Engine>(Engine) {
        auto& simulation = *static_cast<typename Engine::State*>(call.simulation);
        auto& progress = *static_cast<Progress*>(call.progress);
        return static_cast<int>(follow(SerialTeam{}, simulation, static_cast<const Stage*>(call.stages), call.stage_count, progress,
                                       *static_cast<const Rest*>(call.rest), static_cast<Record*>(call.records), call.steps));
    });
}

int run_steps(const ::graincal::RunCall& call) {
    using namespace GRAINCAL_TARGET::graincal;
    return CompiledEngines::visit(call.engine, [&]<class Engine>(Engine) {
        return static_cast<int>(run(SerialTeam{}, *static_cast<typename Engine::State*>(call.simulation), call.last_step));
    });
}
int follow_path_timed(const ::graincal::PathCall& call, double (*now)(), double* seconds) {
    using namespace GRAINCAL_TARGET::graincal;
    return CompiledEngines::visit(call.engine, [&]<class Engine>(Engine) {
        auto& simulation = *static_cast<typename Engine::State*>(call.simulation);
        auto& progress = *static_cast<Progress*>(call.progress);
        Stopwatch watch(now, seconds);
        return static_cast<int>(follow(SerialTeam{}, simulation, static_cast<const Stage*>(call.stages), call.stage_count, progress,
                                       *static_cast<const Rest*>(call.rest), static_cast<Record*>(call.records), call.steps, watch));
    });
}
double multiply_and_add_float64(long long rounds) { return graincal::multiply_and_add<double>(rounds); }
double multiply_and_add_float32(long long rounds) { return graincal::multiply_and_add<float>(rounds); }
void triad(double* a, const double* b, const double* c, long long count) { graincal::triad(a, b, c, count); }

}  // namespace GRAINCAL_TARGET
