#include "targets.hpp"

#if defined(__x86_64__)
namespace x86_64_v2 {
int follow_path(const graincal::PathCall&);
int run_steps(const graincal::RunCall&);
}
namespace x86_64_v3 {
int follow_path(const graincal::PathCall&);
int run_steps(const graincal::RunCall&);
}
namespace x86_64_v4 {
int follow_path(const graincal::PathCall&);
int run_steps(const graincal::RunCall&);
}
#else
namespace baseline {
int follow_path(const graincal::PathCall&);
int run_steps(const graincal::RunCall&);
}
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
    {"x86-64-v2", [] { return true; }, &x86_64_v2::follow_path, &x86_64_v2::run_steps},
    {"x86-64-v3", &runs_v3, &x86_64_v3::follow_path, &x86_64_v3::run_steps},
    {"x86-64-v4", &runs_v4, &x86_64_v4::follow_path, &x86_64_v4::run_steps},
    {nullptr, nullptr, nullptr, nullptr},
};
#else
const Target targets[] = {
    {"baseline", [] { return true; }, &baseline::follow_path, &baseline::run_steps},
    {nullptr, nullptr, nullptr, nullptr},
};
#endif

}  // namespace graincal
