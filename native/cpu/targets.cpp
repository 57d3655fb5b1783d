#include "targets.hpp"

#define GRAINCAL_DECLARE_TARGET(name)                                        \
    namespace name {                                                         \
    int follow_path(const graincal::PathCall&);                              \
    int run_steps(const graincal::RunCall&);                                 \
    int follow_path_timed(const graincal::PathCall&, double (*)(), double*); \
    double multiply_and_add_float64(long long);                              \
    double multiply_and_add_float32(long long);                              \
    void triad(double*, const double*, const double*, long long);            \
    }
#define GRAINCAL_CALLS(name) \
    &name::follow_path, &name::run_steps, { &name::follow_path_timed, &name::multiply_and_add_float64, &name::multiply_and_add_float32, &name::triad }

#if defined(__x86_64__)
GRAINCAL_DECLARE_TARGET(x86_64_v2)
GRAINCAL_DECLARE_TARGET(x86_64_v3)
GRAINCAL_DECLARE_TARGET(x86_64_v4)
#else
GRAINCAL_DECLARE_TARGET(baseline)
#endif

namespace graincal {

#if defined(__x86_64__)
namespace {

// What each level adds to the one before (System V ABI for x86-64). Compilers before g++ 12 do not know the levels by name.
bool runs_v3() {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
           __builtin_cpu_supports("lzcnt") && __builtin_cpu_supports("movbe") && __builtin_cpu_supports("f16c");
}
bool runs_v4() {
    return runs_v3() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}

}  // namespace

const Target targets[] = {
    {"x86-64-v2", [] { return true; }, GRAINCAL_CALLS(x86_64_v2)},
    {"x86-64-v3", &runs_v3, GRAINCAL_CALLS(x86_64_v3)},
    {"x86-64-v4", &runs_v4, GRAINCAL_CALLS(x86_64_v4)},
    {nullptr, nullptr, nullptr, nullptr, {}},
};
#else
const Target targets[] = {
    {"baseline", [] { return true; }, GRAINCAL_CALLS(baseline)},
    {nullptr, nullptr, nullptr, nullptr, {}},
};
#endif

}  // namespace graincal
