// A Team is the group of threads that advances one simulation. All physics is written against its few operations:
//
//   team.each(n, f)       f(i) for every i < n, in any order
//   team.sum(n, f)        sum of f(i), in an order that depends on n alone
//   team.largest(n, f)    maximum of f(i) and zero
//   team.over_pairs(pairs, slots, particles, sums, f)
//                         f(k, one, two, to_first, to_second) evaluates pair k, whose sides are one and two; it calls to_first and to_second with the
//                         parts of what it adds to the sums of its particles, and returns what it adds to a sum over all pairs. All sums start from zero and
//                         are taken in orders that depend on the pairs alone; that over all pairs is returned. slots.fetch(k), which a
//                         team may call ahead, asks for the memory that f itself uses for pair k
//   team.scan(n, a)       a[0..n) becomes its exclusive prefix sum, a[n] the total
//   team.claim(p)         returns *p and adds one to it
//   team.once(f)          f(), by one member alone
//   team.sync()           what was written before is seen after, by every member
//
// Scalars of a simulation live in a copy per member, computed alike by all; only arrays are shared.
// native/cpu has the team of one CPU thread, native/cuda that of a thread block.
#pragma once

#include "arithmetic.hpp"

namespace graincal {

// Partial sums are taken over chunks of this many terms, then added as a balanced binary tree over the chunks.
constexpr Index sum_chunk = 128;

// Adds partial sums, as they come, as a balanced binary tree: level l holds the sum of 2^l of them.
template <class T> class PairwiseSum {
  public:
    void add(T partial) {
        Index l = 0;
        for (; filled_ >> l & 1u; ++l) {
            level_[l] += partial;
            partial = level_[l];
            filled_ &= ~(1u << l);
        }
        level_[l] = partial;
        filled_ |= 1u << l;
    }
    T total() const {
        T total{};
        bool first = true;
        for (Index l = 0; l < 32; ++l)
            if (filled_ >> l & 1u) {
                T sum = level_[l];
                if (!first) sum += total;
                total = sum;
                first = false;
            }
        return total;
    }

  private:
    T level_[32];
    unsigned filled_ = 0;
};

inline void scan_in_order(Index n, Index* values) {
    Index total = 0;
    for (Index i = 0; i < n; ++i) {
        const Index value = values[i];
        values[i] = total;
        total += value;
    }
    values[n] = total;
}

}  // namespace graincal
