// A Team is the group of threads that advances one simulation. All physics is written against its few operations:
//
//   team.each(n, f)       f(i) for every i < n, in any order
//   team.sum(n, f)        sum of f(i), in an order that depends on n alone
//   team.largest(n, f)    maximum of f(i) and zero
//   team.scan(n, a)       a[0..n) becomes its exclusive prefix sum, a[n] the total
//   team.claim(p)         returns *p and adds one to it
//   team.once(f)          f(), by one member alone
//   team.sync()           what was written before is seen after, by every member
//
// Scalars of a simulation live in a copy per member, computed alike by all; only arrays are shared.
// SerialTeam is the team of one CPU thread; native/cuda has the team of a thread block.
#pragma once

#include "arithmetic.hpp"

namespace graincal {

// Partial sums are taken over chunks of this many terms, then added as a balanced binary tree over the chunks.
constexpr Index sum_chunk = 128;

struct SerialTeam {
    // Taken whole into the loop and free of order, f becomes vector code where it has no branches.
    template <class F> [[gnu::flatten]] void each(Index n, F f) const {
#if !defined(__CUDACC_RTC__)
#pragma GCC ivdep
#endif
        for (Index i = 0; i < n; ++i) f(i);
    }

    template <class F> auto sum(Index n, F f) const {
        using T = decltype(f(Index(0)));
        // A binary counter of partial sums: level l holds the sum of 2^l chunks, so the tree is that of a pairwise reduction.
        T level[32];
        unsigned filled = 0;
        for (Index begin = 0; begin < n; begin += sum_chunk) {
            const Index end = minimum(n, begin + sum_chunk);
            T partial{};
            for (Index i = begin; i < end; ++i) partial += f(i);
            Index l = 0;
            for (; filled >> l & 1u; ++l) {
                level[l] += partial;
                partial = level[l];
                filled &= ~(1u << l);
            }
            level[l] = partial;
            filled |= 1u << l;
        }
        T total{};
        bool first = true;
        for (Index l = 0; l < 32; ++l)
            if (filled >> l & 1u) {
                if (!first) level[l] += total;
                total = level[l];
                first = false;
            }
        return total;
    }

    template <class F> auto largest(Index n, F f) const {
        decltype(f(Index(0))) result{};
        for (Index i = 0; i < n; ++i) result = maximum(result, f(i));
        return result;
    }

    void scan(Index n, Index* values) const {
        Index total = 0;
        for (Index i = 0; i < n; ++i) {
            const Index value = values[i];
            values[i] = total;
            total += value;
        }
        values[n] = total;
    }

    // The one operation through which the turns of a loop meet: volatile, or they would be taken for independent and done at once.
    Index claim(volatile Index* counter) const {
        const Index claimed = *counter;
        *counter = claimed + 1;
        return claimed;
    }

    template <class F> void once(F f) const { f(); }

    void sync() const {}
};

}  // namespace graincal
