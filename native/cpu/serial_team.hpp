// The team of one CPU thread. Loops free of order and branches become vector code by the compiler; what it cannot see through are the two turns between
// records and columns, written here with vectors of four numbers: particles are gathered as whole lines of memory and turned into columns, and what pairs
// add is turned back into records, one addition a record.
#pragma once

#include "graincal/particles.hpp"
#include "graincal/team.hpp"

namespace graincal {

typedef float FourFloats __attribute__((vector_size(16), aligned(4), may_alias));
#if defined(__AVX__)
typedef double FourDoubles __attribute__((vector_size(32), aligned(8), may_alias));
#else
// Where vectors hold two: left to the compiler, four would go through memory number by number.
struct FourDoubles {
    typedef double Two __attribute__((vector_size(16), aligned(8), may_alias));
    Two low, high;

    FourDoubles& operator+=(const FourDoubles& b) {
        low += b.low, high += b.high;
        return *this;
    }
    double operator[](Index k) const { return k < 2 ? low[k] : high[k - 2]; }
} __attribute__((may_alias));
#endif
template <class Number> struct FourOf;
template <> struct FourOf<double> {
    typedef FourDoubles Vector;
};
template <> struct FourOf<float> {
    typedef FourFloats Vector;
};
template <class Number> using Four = typename FourOf<Number>::Vector;

template <class Number> [[gnu::always_inline]] inline Four<Number> load(const Number* from) { return *reinterpret_cast<const Four<Number>*>(from); }
template <class Number> [[gnu::always_inline]] inline void store(Number* to, const Four<Number>& v) { *reinterpret_cast<Four<Number>*>(to) = v; }

// The numbers of a and b, counted on from a's first, at these places.
#if defined(__clang__) || __GNUC__ >= 12
#define GRAINCAL_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
template <class Vector, Index size> struct PlacesOf;
template <class Vector> struct PlacesOf<Vector, 8> {
    typedef long long Type __attribute__((vector_size(sizeof(Vector))));
};
template <class Vector> struct PlacesOf<Vector, 4> {
    typedef int Type __attribute__((vector_size(sizeof(Vector))));
};
template <class Vector, class... Places> [[gnu::always_inline]] inline Vector shuffled(const Vector& a, const Vector& b, Places... places) {
    return __builtin_shuffle(a, b, typename PlacesOf<Vector, sizeof(a[0])>::Type{places...});
}
#define GRAINCAL_SHUFFLE(a, b, ...) shuffled(a, b, __VA_ARGS__)
#endif

// Four rows become four columns, and the other way.
template <class Vector> [[gnu::always_inline]] inline void transpose(Vector& a, Vector& b, Vector& c, Vector& d) {
    const Vector ab0 = GRAINCAL_SHUFFLE(a, b, 0, 4, 2, 6), ab1 = GRAINCAL_SHUFFLE(a, b, 1, 5, 3, 7);
    const Vector cd0 = GRAINCAL_SHUFFLE(c, d, 0, 4, 2, 6), cd1 = GRAINCAL_SHUFFLE(c, d, 1, 5, 3, 7);
    a = GRAINCAL_SHUFFLE(ab0, cd0, 0, 1, 4, 5), b = GRAINCAL_SHUFFLE(ab1, cd1, 0, 1, 4, 5);
    c = GRAINCAL_SHUFFLE(ab0, cd0, 2, 3, 6, 7), d = GRAINCAL_SHUFFLE(ab1, cd1, 2, 3, 6, 7);
}
#if !defined(__AVX__)
[[gnu::always_inline]] inline void transpose(FourDoubles& a, FourDoubles& b, FourDoubles& c, FourDoubles& d) {
    const auto even = [](const FourDoubles::Two& x, const FourDoubles::Two& y) { return GRAINCAL_SHUFFLE(x, y, 0, 2); };
    const auto odd = [](const FourDoubles::Two& x, const FourDoubles::Two& y) { return GRAINCAL_SHUFFLE(x, y, 1, 3); };
    const FourDoubles w{even(a.low, b.low), even(c.low, d.low)}, x{odd(a.low, b.low), odd(c.low, d.low)};
    const FourDoubles y{even(a.high, b.high), even(c.high, d.high)}, z{odd(a.high, b.high), odd(c.high, d.high)};
    a = w, b = x, c = y, d = z;
}
#endif

class SerialTeam {
  public:
    template <class F> [[gnu::flatten]] void each(Index n, F f) const {
#pragma GCC ivdep
        for (Index i = 0; i < n; ++i) f(i);
    }

    template <class F> auto sum(Index n, F f) const {
        using T = decltype(f(Index(0)));
        PairwiseSum<T> total;
        for (Index begin = 0; begin < n; begin += sum_chunk) {
            const Index end = minimum(n, begin + sum_chunk);
            T partial{};
            for (Index i = begin; i < end; ++i) partial += f(i);
            total.add(partial);
        }
        return total.total();
    }

    template <class F> [[gnu::flatten]] auto largest(Index n, F f) const {
        using T = decltype(f(Index(0)));
        constexpr Index lanes = 8;
        T lane[lanes]{}, result{};
        Index i = 0;
        for (; i + lanes <= n; i += lanes)
            for (Index l = 0; l < lanes; ++l) lane[l] = maximum(lane[l], f(i + l));
        for (Index l = 0; l < lanes; ++l) result = maximum(result, lane[l]);
        for (; i < n; ++i) result = maximum(result, f(i));
        return result;
    }

    // A chunk of pairs at a time, so that its columns stay in the nearest cache. A particle's sum has its terms in the order of the pairs. What the chunk
    // after the next needs is asked for meanwhile, a little at a time: the shared cache gives enough in all, but not in time where others use it too.
    template <class Slots, class Real, class Sum, class F>
    [[gnu::flatten]] Vec3<Coordinate> over_pairs(const PairEnds& pairs, const Slots& slots, const Particles<Real>& particles, Sum* sums, F f) const {
        write_lines(particles);
        for (Index i = 0; i < particles.count; ++i) sums[i] = Sum{};
        Sides<Real> one, two;
        Terms<Real> to_first, to_second;
        alignas(64) Real to_all[3][chunk];
        PairwiseSum<Vec3<Coordinate>> total;
        const bool far_away = pairs.count > pairs_in_second_cache;
        for (Index begin = 0; begin < pairs.count; begin += chunk) {
            const Index count = minimum(pairs.count - begin, chunk);
            const Index *first = pairs.first + begin, *second = pairs.second + begin;
            one.gather(particles.line, first, count);
            two.gather(particles.line, second, count);
#pragma GCC ivdep
            for (Index k = 0; k < count; ++k) {
                const auto take_first = [&](const auto&... parts) { Sum::number([&](Index c, Real value) { to_first.column[c][k] = value; }, parts...); };
                const auto take_second = [&](const auto&... parts) { Sum::number([&](Index c, Real value) { to_second.column[c][k] = value; }, parts...); };
                const Vec3<Real> term = f(begin + k, one.side(k), two.side(k), take_first, take_second);
                to_all[0][k] = term.x, to_all[1][k] = term.y, to_all[2][k] = term.z;
            }
            const Index ahead = minimum(begin + 2 * chunk, pairs.count - chunk);
            for (Index k = 0; k < count; k += 4) {
                if (far_away) fetch_four(ahead + k, pairs, slots, particles.line, sums);
                const Index some = minimum(count - k, Index(4));
                Four<Real> head1[4], tail1[4], head2[4], tail2[4];
                to_first.rows(k, head1, tail1);
                to_second.rows(k, head2, tail2);
                for (Index l = 0; l < some; ++l) {
                    add(sums[first[k + l]], head1[l], tail1[l]);
                    add(sums[second[k + l]], head2[l], tail2[l]);
                }
            }
            total.add({column_sum(to_all[0], count), column_sum(to_all[1], count), column_sum(to_all[2], count)});
        }
        return total.total();
    }

    void scan(Index n, Index* values) const { scan_in_order(n, values); }

    // The one operation through which the turns of a loop meet: volatile, or they would be taken for independent and done at once.
    Index claim(volatile Index* counter) const {
        const Index claimed = *counter;
        *counter = claimed + 1;
        return claimed;
    }

    template <class F> void once(F f) const { f(); }

    void sync() const {}

  private:
    static constexpr Index chunk = 64;

    static constexpr Index cache_line = 64;  // bytes

    // No more than these are held by the second cache, from which loads are in time by themselves.
    static constexpr Index pairs_in_second_cache = 8192;

    // Asks for what four pairs read and write, but for their first particles, which come in order.
    template <class Slots, class Real, class Sum>
    [[gnu::always_inline]] static inline void fetch_four(Index k, const PairEnds& pairs, const Slots& slots, const Line<Real>* lines, const Sum* sums) {
        if (k * Index(sizeof(Real)) % cache_line < 4 * Index(sizeof(Real))) slots.fetch(k);
        for (Index l = k; l < k + 4; ++l) {
            const Index second = pairs.second[l];
            fetch_ahead(&lines[second]), fetch_ahead(lines[second].motion + 4), fetch_ahead(&sums[second]);
        }
    }

    // Each particle's numbers side by side, as gathers want them.
    template <class Real> static void write_lines(const Particles<Real>& p) {
        const Index n = p.count, whole = n / 4 * 4;
        for (Index i = 0; i < whole; i += 4) {
            Four<Coordinate> x = load(p.fractional.x + i), y = load(p.fractional.y + i), z = load(p.fractional.z + i), r = load(p.radius + i);
            Four<Real> u = load(p.velocity.x + i), v = load(p.velocity.y + i), w = load(p.velocity.z + i), a = load(p.spin.x + i);
            Four<Real> b = load(p.spin.y + i), c = load(p.spin.z + i), none{}, nought{};
            transpose(x, y, z, r), transpose(u, v, w, a), transpose(b, c, none, nought);
            const Four<Coordinate> place[4] = {x, y, z, r};
            const Four<Real> head[4] = {u, v, w, a}, tail[4] = {b, c, none, nought};
            for (Index l = 0; l < 4; ++l) {
                Line<Real>& line = p.line[i + l];
                store(line.place, place[l]), store(line.motion, head[l]), store(line.motion + 4, tail[l]);
            }
        }
        for (Index i = whole; i < n; ++i)
            p.line[i] = {{p.fractional.x[i], p.fractional.y[i], p.fractional.z[i], p.radius[i]},
                         {p.velocity.x[i], p.velocity.y[i], p.velocity.z[i], p.spin.x[i], p.spin.y[i], p.spin.z[i], 0, 0}};
    }

    // One side of a chunk of pairs, in columns.
    template <class Real> struct Sides {
        alignas(64) Coordinate place[4][chunk];
        alignas(64) Real motion[6][chunk];

        void gather(const Line<Real>* lines, const Index* index, Index count) {
            for (Index k = 0; k < count; k += 4) {
                const Line<Real>* from[4];
                for (Index l = 0; l < 4; ++l) from[l] = &lines[index[minimum(k + l, count - 1)]];
                Four<Coordinate> x = load(from[0]->place), y = load(from[1]->place), z = load(from[2]->place), r = load(from[3]->place);
                transpose(x, y, z, r);
                store(place[0] + k, x), store(place[1] + k, y), store(place[2] + k, z), store(place[3] + k, r);
                Four<Real> u = load(from[0]->motion), v = load(from[1]->motion), w = load(from[2]->motion), a = load(from[3]->motion);
                transpose(u, v, w, a);
                store(motion[0] + k, u), store(motion[1] + k, v), store(motion[2] + k, w), store(motion[3] + k, a);
                Four<Real> b = load(from[0]->motion + 4), c = load(from[1]->motion + 4), d = load(from[2]->motion + 4), e = load(from[3]->motion + 4);
                transpose(b, c, d, e);
                store(motion[4] + k, b), store(motion[5] + k, c);
            }
        }
        PairSide<Real> side(Index k) const {
            return {
                {place[0][k], place[1][k], place[2][k]}, place[3][k], {motion[0][k], motion[1][k], motion[2][k]}, {motion[3][k], motion[4][k], motion[5][k]}};
        }
    };

    // What a chunk of pairs adds to one of their ends, in columns.
    template <class Real> struct Terms {
        alignas(64) Real column[8][chunk];

        // The records of four pairs: their first four numbers, and the others.
        void rows(Index k, Four<Real>* head, Four<Real>* tail) const {
            for (Index c = 0; c < 4; ++c) {
                head[c] = load(column[c] + k);
                tail[c] = load(column[4 + c] + k);
            }
            transpose(head[0], head[1], head[2], head[3]);
            transpose(tail[0], tail[1], tail[2], tail[3]);
        }
    };

    template <class Sum, class Vector> static void add(Sum& sum, const Vector& head, const Vector& tail) {
        static_assert(sizeof(Sum) == 2 * sizeof(Vector));
        Vector* numbers = reinterpret_cast<Vector*>(&sum);
        numbers[0] += head, numbers[1] += tail;
    }

    // Dealt to eight lanes, whatever the vectors of the machine.
    template <class Real> static Coordinate column_sum(Real* column, Index count) {
        const Index whole = (count + 7) / 8 * 8;
        for (Index k = count; k < whole; ++k) column[k] = Real(0);
        Four<Real> low{}, high{};
        for (Index k = 0; k < whole; k += 8) low += load(column + k), high += load(column + k + 4);
        low += high;
        return (Coordinate(low[0]) + Coordinate(low[2])) + (Coordinate(low[1]) + Coordinate(low[3]));
    }
};

#undef GRAINCAL_SHUFFLE

}  // namespace graincal
