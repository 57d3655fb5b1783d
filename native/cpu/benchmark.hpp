// Where the time of a run goes, and what the machine could do in it: for benchmarks/engine.py alone. Compiled like the step, once per instruction set.
#pragma once

#include "graincal/stress_path.hpp"

namespace graincal {

using Clock = double (*)();  // s

// Adds the time since the pass before to the seconds of the one that has ended.
class Stopwatch {
  public:
    Stopwatch(Clock now, double* seconds) : now_(now), seconds_(seconds), before_(now()) {}

    void operator()(Pass pass) {
        const double after = now_();
        seconds_[static_cast<int>(pass)] += after - before_;
        before_ = after;
    }

  private:
    Clock now_;
    double* seconds_;
    double before_;
};

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
