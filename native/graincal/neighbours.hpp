// Who may touch whom, at two distances. The outer list, found on a grid, holds the pairs within a generous gap and is rebuilt rarely; from it
// come the near pairs, whose slots the force pass visits. A slot's history moves with its pair: column by column, each into the memory that the last one
// left, so that a simulation holds its contacts once.
#pragma once

#include "cell.hpp"
#include "contacts.hpp"
#include "particles.hpp"

namespace graincal {

enum class NeighbourStatus { ready, out_of_order, outer_full, near_full, cell_too_small, out_of_place };

template <class Real> struct Neighbours {
    using Terms = PairTerms<Load<Real>>;
    static constexpr Index found_room = 16;
    static constexpr Index rebuilds_in_an_order = 8;  // of the outer list, in which a particle moves a grain's size or two: then they are sorted anew
    static_assert(sizeof(Terms) == sizeof(PairTerms<StiffnessSum<Real>>));

    Index count = 0;  // of particles
    Index outer_capacity = 0, near_capacity = 0, grid_capacity = 0;
    Coordinate widest_outer_gap;     // m, where the cell is wide enough for it
    Coordinate outer_gap, near_gap;  // pairs whose surfaces are closer than this are listed, m
    Coordinate largest_radius;
    bool outer_valid = false, near_valid = false;

    Index* outer_row;  // (N + 1)
    Index *outer_first, *outer_second;
    Index* outer_near;                           // whether each outer pair is a near one
    Index* found;                                // (N, found_room) seconds of outer pairs as they are counted, so that most need not be sought again
    PairSlots<Real> slots;                       // the near pairs
    Index *next_row, *next_first, *next_second;  // of the near pairs, as they are gathered
    Index* slot_before;                          // of each of them, or -1
    Real* next_column;                           // where the next column is moved
    bool terms_land = false;                     // for a team that lands the terms of pairs, and looks up which come in at a particle (PairEnds)
    Index* incoming_row;                         // (N + 1)
    Index* incoming;
    char* landing;
    Vec3Array<Coordinate> outer_reference, near_reference;  // fractional coordinates when each list was made
    Mat3<Coordinate> outer_edges, near_edges;
    Coordinate travel = 0;  // no particle has moved further than this against the cell since near_reference, m
    Index* cell_of;         // grid: particle -> grid cell, and the particles of each cell
    Index* grid_row;
    Index* grid_member;
    Index* counter;  // (max(N, grid) + 1)
    Index outer_rebuilds = 0, near_rebuilds = 0;

    void lay_out(Arena& arena, Index n, Index outer_pairs, Index near_pairs, bool lands) {
        count = n;
        outer_capacity = outer_pairs;
        near_capacity = near_pairs;
        grid_capacity = 2 * n + 64;
        outer_row = arena.take<Index>(n + 1);
        outer_first = arena.take<Index>(outer_pairs);
        outer_second = arena.take<Index>(outer_pairs);
        outer_near = arena.take<Index>(outer_pairs);
        found = arena.take<Index>(found_room * n);
        slots.lay_out(arena, n, near_pairs);
        next_row = arena.take<Index>(n + 1);
        next_first = arena.take<Index>(near_pairs);
        next_second = arena.take<Index>(near_pairs);
        slot_before = arena.take<Index>(near_pairs);
        next_column = arena.take<Real>(near_pairs);
        terms_land = lands;
        incoming_row = arena.take<Index>(lands ? n + 1 : 0);
        incoming = arena.take<Index>(lands ? near_pairs : 0);
        landing = reinterpret_cast<char*>(arena.take<Terms>(lands ? near_pairs : 0));
        outer_reference = arena.take_vectors<Coordinate>(n);
        near_reference = arena.take_vectors<Coordinate>(n);
        cell_of = arena.take<Index>(n);
        grid_row = arena.take<Index>(grid_capacity + 1);
        grid_member = arena.take<Index>(n);
        counter = arena.take<Index>(grid_capacity + 1);
    }
    Coordinate reach(Coordinate gap) const { return 2 * largest_radius + gap; }
    PairEnds ends() const { return {slots.row[count], slots.first, slots.second, slots.row, incoming_row, incoming, landing}; }
};

// How far two particles within the outer reach can have come closer since the reference, if each has moved at most `travel` against the cell: by their
// own motion, which the cell stretches after it, and by the cell's deformation.
template <class Real> Coordinate closing(const Neighbours<Real>& list, const Cell& cell, const Mat3<Coordinate>& reference_edges, Coordinate travel) {
    const Coordinate stretch = frobenius_norm(cell.edges * inverse(reference_edges) - Mat3<Coordinate>::identity());
    return (1 + stretch) * 2 * travel + stretch * list.reach(list.outer_gap);
}

// The furthest that a particle has moved against the cell since the reference, m.
template <class Team, class Real>
Coordinate furthest_travel(const Team& team, const Particles<Real>& particles, const Cell& cell, const Vec3Array<Coordinate>& reference) {
    const Coordinate squared = team.largest(particles.count, [&](Index i) {
        const Vec3<Coordinate> moved = cell.edges * (particles.fractional[i] - reference[i]);
        return dot(moved, moved);
    });
    return square_root(squared);
}

inline void sort_ascending(Index* begin, Index* end) {
    for (Index* p = begin + (begin < end); p < end; ++p)
        for (Index* q = p; q > begin && *q < *(q - 1); --q) exchange(*q, *(q - 1));
}

// A grid over the cell whose meshes are at least the outer reach wide.
struct Grid {
    Index n[3];

    Grid(const Vec3<Coordinate>& widths, Coordinate reach, Index capacity) {
        Coordinate mesh = reach;
        do {
            for (Index axis = 0; axis < 3; ++axis) n[axis] = maximum(Index(1), Index(minimum(widths[axis] / mesh, Coordinate(capacity))));
            mesh *= 1.1;
        } while (Coordinate(n[0]) * Coordinate(n[1]) * Coordinate(n[2]) > Coordinate(capacity));
    }
    Index size() const { return n[0] * n[1] * n[2]; }
    Index mesh_of(Coordinate s, Index axis) const {
        // Rounding can put a coordinate just below one onto the upper face.
        return minimum(Index(s * Coordinate(n[axis])), n[axis] - 1);
    }
    Index cell_of(const Vec3<Coordinate>& s) const { return (mesh_of(s.x, 0) * n[1] + mesh_of(s.y, 1)) * n[2] + mesh_of(s.z, 2); }

    // Visits each distinct mesh around (and including) the given one.
    template <class F> void around(Index cell, F f) const {
        const Index at[3] = {cell / (n[1] * n[2]), cell / n[2] % n[1], cell % n[2]};
        Index first[3], count[3];
        for (Index axis = 0; axis < 3; ++axis) {
            count[axis] = minimum(n[axis], Index(3));
            first[axis] = n[axis] < 3 ? 0 : at[axis] - 1 + n[axis];
        }
        for (Index a = 0; a < count[0]; ++a)
            for (Index b = 0; b < count[1]; ++b)
                for (Index c = 0; c < count[2]; ++c) f(((first[0] + a) % n[0] * n[1] + (first[1] + b) % n[1]) * n[2] + (first[2] + c) % n[2]);
    }
};

inline Coordinate wrapped(Coordinate s) {
    // s - floor(s), in [0, 1) or exactly 1 by rounding
    const Coordinate whole = nearest_integer(s);
    return s < whole ? s - whole + 1 : s - whole;
}

// Whether every particle has a place on a grid over a cell of these widths: all coordinates are finite.
template <class Team, class Real> bool are_in_place(const Team& team, const Particles<Real>& particles, const Vec3<Coordinate>& widths) {
    if (!is_finite(widths.x + widths.y + widths.z)) return false;
    const Vec3Array<Coordinate> fractional = particles.fractional;
    return team.largest(particles.count, [=](Index i) { return is_finite(fractional.x[i] + fractional.y[i] + fractional.z[i]) ? 0.0 : 1.0; }) == 0;
}

// Finds all pairs closer than the outer gap.
template <class Team, class Real> NeighbourStatus rebuild_outer(const Team& team, Neighbours<Real>& list, const Particles<Real>& particles, const Cell& cell) {
    const Index n = particles.count;
    const Vec3<Coordinate> widths = cell.widths();
    // Below two reaches a pair could touch through two images at once.
    const Coordinate fitting = 0.5 * minimum(widths.x, minimum(widths.y, widths.z)) - 2 * list.largest_radius;
    if (!(fitting > 2 * list.near_gap)) return NeighbourStatus::cell_too_small;
    // Who is nowhere has no mesh, and must not be counted into one.
    if (!are_in_place(team, particles, widths)) return NeighbourStatus::out_of_place;
    list.outer_gap = minimum(list.widest_outer_gap, 0.999 * fitting);
    const Coordinate reach = list.reach(list.outer_gap);
    const Grid grid(widths, reach, list.grid_capacity);

    team.each(grid.size() + 1, [&](Index c) { list.grid_row[c] = 0; });
    team.sync();
    team.each(n, [&](Index i) {
        const Vec3<Coordinate> s = particles.fractional[i];
        list.outer_reference.set(i, s);
        list.cell_of[i] = grid.cell_of({wrapped(s.x), wrapped(s.y), wrapped(s.z)});
        team.claim(&list.grid_row[list.cell_of[i]]);
    });
    team.sync();
    team.scan(grid.size(), list.grid_row);
    team.each(grid.size(), [&](Index c) { list.counter[c] = list.grid_row[c]; });
    team.sync();
    team.each(n, [&](Index i) { list.grid_member[team.claim(&list.counter[list.cell_of[i]])] = i; });
    team.sync();

    const auto visit = [&](Index i, auto f) {
        grid.around(list.cell_of[i], [&](Index c) {
            for (Index m = list.grid_row[c]; m < list.grid_row[c + 1]; ++m) {
                const Index j = list.grid_member[m];
                if (j <= i) continue;
                const Vec3<Coordinate> r = cell.branch(particles.fractional[i], particles.fractional[j]);
                const Coordinate within = particles.radius[i] + particles.radius[j] + list.outer_gap;
                if (dot(r, r) < within * within) f(j);
            }
        });
    };
    team.each(n, [&](Index i) {
        Index count = 0, *const found = list.found + list.found_room * i;
        visit(i, [&](Index j) {
            if (count < list.found_room) found[count] = j;
            ++count;
        });
        list.outer_row[i] = count;
    });
    team.sync();
    team.scan(n, list.outer_row);
    if (list.outer_row[n] > list.outer_capacity) {
        list.outer_valid = false;
        return NeighbourStatus::outer_full;
    }
    team.each(n, [&](Index i) {
        Index* const begin = list.outer_second + list.outer_row[i];
        Index* next = begin;
        const Index count = list.outer_row[i + 1] - list.outer_row[i], *const found = list.found + list.found_room * i;
        if (count <= list.found_room)
            while (next < begin + count) *next = found[next - begin], ++next;
        else
            visit(i, [&](Index j) { *next++ = j; });
        sort_ascending(begin, next);
        for (Index p = list.outer_row[i]; p < list.outer_row[i + 1]; ++p) list.outer_first[p] = i;
    });
    team.sync();
    list.outer_edges = cell.edges;
    list.outer_valid = true;
    ++list.outer_rebuilds;
    return NeighbourStatus::ready;
}

// Lists for each particle the near pairs of which it is the second.
template <class Team, class Real> void list_incoming(const Team& team, Neighbours<Real>& list) {
    const Index n = list.count, pairs = list.slots.row[n];
    team.each(n + 1, [&](Index j) { list.incoming_row[j] = 0; });
    team.sync();
    team.each(pairs, [&](Index slot) { team.claim(&list.incoming_row[list.slots.second[slot]]); });
    team.sync();
    team.scan(n, list.incoming_row);
    team.each(n, [&](Index j) { list.counter[j] = list.incoming_row[j]; });
    team.sync();
    team.each(pairs, [&](Index slot) { list.incoming[team.claim(&list.counter[list.slots.second[slot]])] = slot; });
    team.sync();
    team.each(n, [&](Index j) { sort_ascending(list.incoming + list.incoming_row[j], list.incoming + list.incoming_row[j + 1]); });
    team.sync();
}

// Picks the near pairs from the outer list and moves the histories to their new slots.
template <class Team, class Real> NeighbourStatus rebuild_near(const Team& team, Neighbours<Real>& list, const Particles<Real>& particles, const Cell& cell) {
    const Index n = particles.count;
    PairSlots<Real>& slots = list.slots;
    const Neighbours<Real> outer = list;
    const Particles<Real> p = particles;
    const Cell now = cell;
    team.each(list.outer_row[n], [=](Index k) {
        const Index i = outer.outer_first[k], j = outer.outer_second[k];
        const Vec3<Coordinate> r = now.branch(p.fractional[i], p.fractional[j]);
        const Coordinate within = p.radius[i] + p.radius[j] + outer.near_gap;
        outer.outer_near[k] = dot(r, r) < within * within ? 1 : 0;
    });
    team.sync();
    team.each(n, [&](Index i) {
        Index count = 0;
        for (Index k = list.outer_row[i]; k < list.outer_row[i + 1]; ++k) count += list.outer_near[k];
        list.next_row[i] = count;
    });
    team.sync();
    team.scan(n, list.next_row);
    const Index pairs = list.next_row[n];
    if (pairs > list.near_capacity) {
        list.near_valid = false;
        return NeighbourStatus::near_full;
    }
    team.each(n, [&](Index i) {
        Index slot = list.next_row[i], before = slots.row[i];
        for (Index k = list.outer_row[i]; k < list.outer_row[i + 1]; ++k) {
            if (!list.outer_near[k]) continue;
            const Index j = list.outer_second[k];
            while (before < slots.row[i + 1] && slots.second[before] < j) ++before;
            const bool known = before < slots.row[i + 1] && slots.second[before] == j;
            list.next_first[slot] = i;
            list.next_second[slot] = j;
            list.slot_before[slot] = known ? before : -1;
            ++slot;
        }
        list.near_reference.set(i, particles.fractional[i]);
    });
    team.sync();
    exchange(slots.row, list.next_row), exchange(slots.first, list.next_first), exchange(slots.second, list.next_second);
    slots.each_column([&](Real*& column, Real none) {
        const Real* const from = column;
        Real* const to = list.next_column;
        const Index* const before = list.slot_before;
        team.each(pairs, [=](Index slot) {
            const Real kept = from[maximum(before[slot], Index(0))];
            to[slot] = before[slot] < 0 ? none : kept;
        });
        team.sync();
        exchange(column, list.next_column);
    });
    if (list.terms_land) list_incoming(team, list);
    list.near_edges = cell.edges;
    list.near_valid = true;
    list.travel = 0;
    ++list.near_rebuilds;
    return NeighbourStatus::ready;
}

// Makes sure that every pair which touches at the present positions has a slot. Where particles are out of order, or a list is full, the simulation is
// untouched: the host sorts them, or makes room, and both lists are built from nothing.
template <class Team, class Real>
NeighbourStatus update_neighbours(const Team& team, Neighbours<Real>& list, const Particles<Real>& particles, const Cell& cell) {
    const auto near_is_enough = [&] { return list.near_valid && closing(list, cell, list.near_edges, list.travel) < list.near_gap; };
    if (near_is_enough()) return NeighbourStatus::ready;
    if (list.near_valid) {
        // `travel` adds up largest velocities, an upper bound: look at the particles themselves before rebuilding.
        list.travel = furthest_travel(team, particles, cell, list.near_reference);
        const Coordinate worth_keeping = 0.8 * list.near_gap;
        if (closing(list, cell, list.near_edges, list.travel) < worth_keeping) return NeighbourStatus::ready;
    }
    const auto outer_is_enough = [&] {
        const Coordinate travel = furthest_travel(team, particles, cell, list.outer_reference);
        return closing(list, cell, list.outer_edges, travel) + list.near_gap < list.outer_gap;
    };
    if (!list.outer_valid || !outer_is_enough()) {
        const bool order_is_old = list.outer_valid && list.outer_rebuilds % list.rebuilds_in_an_order == 0;
        if (order_is_old) return NeighbourStatus::out_of_order;
        const NeighbourStatus status = rebuild_outer(team, list, particles, cell);
        if (status != NeighbourStatus::ready) return status;
    }
    return rebuild_near(team, list, particles, cell);
}

}  // namespace graincal
