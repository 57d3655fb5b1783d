// The team of one CUDA thread block. The contract is that of team.hpp; `sum` follows the same tree as that of a CPU thread; sums over pairs are taken in
// another order.
#pragma once

#include "graincal/particles.hpp"
#include "graincal/team.hpp"

namespace graincal {

class BlockTeam {
  public:
    // `scratch` is shared memory of this many bytes; it bounds how many chunks a sum may have.
    static constexpr Index scratch_bytes = 32 * 1024;

    explicit BlockTeam(char* scratch) : scratch_(scratch) {}

    template <class F> void each(Index n, F f) const {
        for (Index i = threadIdx.x; i < n; i += blockDim.x) f(i);
    }

    template <class F> auto sum(Index n, F f) const {
        using T = decltype(f(Index(0)));
        constexpr Index capacity = scratch_bytes / sizeof(T);
        const Index chunks = (n + sum_chunk - 1) / sum_chunk;
        T* partial = reinterpret_cast<T*>(scratch_);
        // More chunks than fit are folded in blocks of a power of two, which leaves the tree as it is.
        Index width = 1;
        while ((chunks + width - 1) / width > capacity) width *= 2;
        const Index blocks = (chunks + width - 1) / width;
        sync();
        for (Index b = threadIdx.x; b < blocks; b += blockDim.x) partial[b] = block_sum<T>(b * width, width, chunks, n, f);
        for (Index step = 1; step < blocks; step *= 2) {
            sync();
            for (Index b = 2 * step * threadIdx.x; b + step < blocks; b += 2 * step * blockDim.x) partial[b] += partial[b + step];
        }
        sync();
        const T total = blocks > 0 ? partial[0] : T{};
        sync();
        return total;
    }

    template <class F> auto largest(Index n, F f) const {
        using T = decltype(f(Index(0)));
        T* partial = reinterpret_cast<T*>(scratch_);
        T result{};
        for (Index i = threadIdx.x; i < n; i += blockDim.x) result = maximum(result, f(i));
        sync();
        partial[threadIdx.x] = result;
        for (Index step = 1; step < Index(blockDim.x); step *= 2) {
            sync();
            const Index b = 2 * step * threadIdx.x;
            if (b + step < Index(blockDim.x)) partial[b] = maximum(partial[b], partial[b + step]);
        }
        sync();
        result = partial[0];
        sync();
        return result;
    }

    // Each pair lands its terms in a place of its own; each particle then looks up its pairs', in their order.
    template <class Slots, class Real, class Sum, class F>
    Vec3<Coordinate> over_pairs(const PairEnds& pairs, const Slots&, const Particles<Real>& particles, Sum* sums, F f) const {
        PairTerms<Sum>* landed = reinterpret_cast<PairTerms<Sum>*>(pairs.landing);
        each(pairs.count, [&](Index k) {
            PairTerms<Sum>& terms = landed[k];
            const auto take_first = [&](const auto&... parts) { terms.to_first = Sum{parts...}; };
            const auto take_second = [&](const auto&... parts) { terms.to_second = Sum{parts...}; };
            terms.to_all = f(k, particles.side(pairs.first[k]), particles.side(pairs.second[k]), take_first, take_second);
        });
        sync();
        each(particles.count, [&](Index i) {
            Sum sum{};
            for (Index at = pairs.incoming_row[i]; at < pairs.incoming_row[i + 1]; ++at) sum += landed[pairs.incoming[at]].to_second;
            for (Index k = pairs.row[i]; k < pairs.row[i + 1]; ++k) sum += landed[k].to_first;
            sums[i] = sum;
        });
        return this->sum(pairs.count, [&](Index k) { return as<Coordinate>(landed[k].to_all); });
    }

    void scan(Index n, Index* values) const {
        sync();
        if (threadIdx.x == 0) scan_in_order(n, values);
        sync();
    }

    Index claim(Index* counter) const { return atomicAdd(counter, 1); }

    template <class F> void once(F f) const {
        if (threadIdx.x == 0) f();
    }

    void sync() const { __syncthreads(); }

  private:
    // The sum of `width` chunks from `first`, as a balanced tree.
    template <class T, class F> static T block_sum(Index first, Index width, Index chunks, Index n, F f) {
        T level[32];
        for (Index done = 0; done < width; ++done) {
            const Index chunk = first + done;
            if (chunk >= chunks) return collapse(level, done);
            T carried{};
            const Index end = minimum(n, (chunk + 1) * sum_chunk);
            for (Index i = chunk * sum_chunk; i < end; ++i) carried += f(i);
            Index l = 0;
            for (; done >> l & 1; ++l) {
                level[l] += carried;
                carried = level[l];
            }
            level[l] = carried;
        }
        return collapse(level, width);
    }
    template <class T> static T collapse(T* level, Index count) {
        T total{};
        bool first = true;
        for (Index l = 0; count >> l; ++l)
            if (count >> l & 1) {
                if (!first) level[l] += total;
                total = level[l];
                first = false;
            }
        return total;
    }

    char* scratch_;
};

}  // namespace graincal
