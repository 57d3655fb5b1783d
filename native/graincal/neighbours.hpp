// Who may touch whom, at two distances. The outer list, found on a grid, holds the pairs within a generous gap and is rebuilt rarely; from it
// come the near pairs, whose slots the force pass visits. A slot's history moves with its pair.
#pragma once

#include "cell.hpp"
#include "contacts.hpp"
#include "particles.hpp"

namespace graincal {

enum class NeighbourStatus { ready, outer_full, near_full, cell_too_small };

template <class Real> struct Neighbours {
    Index outer_capacity = 0, near_capacity = 0, grid_capacity = 0;
    Real outer_gap, near_gap;    // pairs whose surfaces are closer than this are listed, m
    Real largest_radius;
    bool outer_valid = false, near_valid = false;

    Index* outer_row;            // (N + 1)
    Index* outer_second;
    PairSlots<Real> slots;       // the near pairs
    PairSlots<Real> spare;       // where the next near pairs are gathered
    Index* incoming_row;         // (N + 1): incoming[incoming_row[j]...] are the slots whose second particle is j
    Index* incoming;
    Vec3Array<Real> outer_reference, near_reference;  // fractional coordinates when each list was made
    Mat3<Real> outer_edges, near_edges;
    Real travel = 0;             // no particle has moved further than this against the cell since near_reference, m
    Index* cell_of;              // grid: particle -> grid cell, and the particles of each cell
    Index* grid_row;
    Index* grid_member;
    Index* counter;              // (max(N, grid) + 1)
    Index outer_rebuilds = 0, near_rebuilds = 0;

    void lay_out(Arena& arena, Index n, Index outer_pairs, Index near_pairs) {
        outer_capacity = outer_pairs;
        near_capacity = near_pairs;
        grid_capacity = 2 * n + 64;
        outer_row = arena.take<Index>(n + 1);
        outer_second = arena.take<Index>(outer_pairs);
        slots.lay_out(arena, n, near_pairs);
        spare.lay_out(arena, n, near_pairs);
        incoming_row = arena.take<Index>(n + 1);
        incoming = arena.take<Index>(near_pairs);
        outer_reference = arena.take_vectors<Real>(n);
        near_reference = arena.take_vectors<Real>(n);
        cell_of = arena.take<Index>(n);
        grid_row = arena.take<Index>(grid_capacity + 1);
        grid_member = arena.take<Index>(n);
        counter = arena.take<Index>(grid_capacity + 1);
    }
    Real reach(Real gap) const { return Real(2) * largest_radius + gap; }
};

// How far two particles within the outer reach can have come closer since the reference, if each has moved at most `travel` against the cell: by their
// own motion, which the cell stretches after it, and by the cell's deformation.
template <class Real>
Real closing(const Neighbours<Real>& list, const Cell<Real>& cell, const Mat3<Real>& reference_edges, Real travel) {
    const Real stretch = frobenius_norm(cell.edges * inverse(reference_edges) - Mat3<Real>::identity());
    return (Real(1) + stretch) * Real(2) * travel + stretch * list.reach(list.outer_gap);
}

// The furthest that a particle has moved against the cell since the reference, m.
template <class Team, class Real>
Real furthest_travel(const Team& team, const Particles<Real>& particles, const Cell<Real>& cell, const Vec3Array<Real>& reference) {
    const Real squared = team.largest(particles.count, [&](Index i) {
        const Vec3<Real> moved = cell.edges * (particles.fractional[i] - reference[i]);
        return dot(moved, moved);
    });
    return square_root(squared);
}

inline void sort_ascending(Index* begin, Index* end) {
    for (Index* p = begin + (begin < end); p < end; ++p)
        for (Index* q = p; q > begin && *q < *(q - 1); --q) exchange(*q, *(q - 1));
}

// A grid over the cell whose meshes are at least the outer reach wide.
template <class Real> struct Grid {
    Index n[3];

    Grid(const Vec3<Real>& widths, Real reach, Index capacity) {
        Real mesh = reach;
        do {
            for (Index axis = 0; axis < 3; ++axis) n[axis] = maximum(Index(1), Index(minimum(widths[axis] / mesh, Real(capacity))));
            mesh *= Real(1.1);
        } while (Real(n[0]) * Real(n[1]) * Real(n[2]) > Real(capacity));
    }
    Index size() const { return n[0] * n[1] * n[2]; }
    Index mesh_of(Real s, Index axis) const {
        // Rounding can put a coordinate just below one onto the upper face.
        return minimum(Index(s * Real(n[axis])), n[axis] - 1);
    }
    Index cell_of(const Vec3<Real>& s) const { return (mesh_of(s.x, 0) * n[1] + mesh_of(s.y, 1)) * n[2] + mesh_of(s.z, 2); }

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
                for (Index c = 0; c < count[2]; ++c)
                    f(((first[0] + a) % n[0] * n[1] + (first[1] + b) % n[1]) * n[2] + (first[2] + c) % n[2]);
    }
};

template <class Real> Real wrapped(Real s) {
    // s - floor(s), in [0, 1) or exactly 1 by rounding
    const Real whole = nearest_integer(s);
    return s < whole ? s - whole + Real(1) : s - whole;
}

// Finds all pairs closer than the outer gap.
template <class Team, class Real>
NeighbourStatus rebuild_outer(const Team& team, Neighbours<Real>& list, const Particles<Real>& particles, const Cell<Real>& cell) {
    const Index n = particles.count;
    const Real reach = list.reach(list.outer_gap);
    const Vec3<Real> widths = cell.widths();
    // Below two reaches a pair could touch through two images at once.
    if (!(minimum(widths.x, minimum(widths.y, widths.z)) > Real(2) * reach)) return NeighbourStatus::cell_too_small;
    const Grid<Real> grid(widths, reach, list.grid_capacity);

    team.each(grid.size() + 1, [&](Index c) { list.grid_row[c] = 0; });
    team.sync();
    team.each(n, [&](Index i) {
        const Vec3<Real> s = particles.fractional[i];
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
                const Vec3<Real> r = cell.branch(particles.fractional[i], particles.fractional[j]);
                const Real within = particles.radius[i] + particles.radius[j] + list.outer_gap;
                if (dot(r, r) < within * within) f(j);
            }
        });
    };
    team.each(n, [&](Index i) {
        Index count = 0;
        visit(i, [&](Index) { ++count; });
        list.outer_row[i] = count;
    });
    team.sync();
    team.scan(n, list.outer_row);
    if (list.outer_row[n] > list.outer_capacity) {
        list.outer_valid = false;
        return NeighbourStatus::outer_full;
    }
    team.each(n, [&](Index i) {
        Index* next = list.outer_second + list.outer_row[i];
        visit(i, [&](Index j) { *next++ = j; });
        sort_ascending(list.outer_second + list.outer_row[i], next);
    });
    team.sync();
    list.outer_edges = cell.edges;
    list.outer_valid = true;
    ++list.outer_rebuilds;
    return NeighbourStatus::ready;
}

// Picks the near pairs from the outer list and moves the histories to their new slots.
template <class Team, class Real>
NeighbourStatus rebuild_near(const Team& team, Neighbours<Real>& list, const Particles<Real>& particles, const Cell<Real>& cell) {
    const Index n = particles.count;
    const PairSlots<Real>&old = list.slots, &fresh = list.spare;
    const auto visit = [&](Index i, auto f) {
        for (Index p = list.outer_row[i]; p < list.outer_row[i + 1]; ++p) {
            const Index j = list.outer_second[p];
            const Vec3<Real> r = cell.branch(particles.fractional[i], particles.fractional[j]);
            const Real within = particles.radius[i] + particles.radius[j] + list.near_gap;
            if (dot(r, r) < within * within) f(j);
        }
    };
    team.each(n, [&](Index i) {
        Index count = 0;
        visit(i, [&](Index) { ++count; });
        fresh.row[i] = count;
    });
    team.sync();
    team.scan(n, fresh.row);
    if (fresh.row[n] > list.near_capacity) {
        list.near_valid = false;
        return NeighbourStatus::near_full;
    }
    team.each(n + 1, [&](Index j) { list.incoming_row[j] = 0; });
    team.sync();
    team.each(n, [&](Index i) {
        Index slot = fresh.row[i], before = old.row[i];
        visit(i, [&](Index j) {
            while (before < old.row[i + 1] && old.second[before] < j) ++before;
            const bool known = before < old.row[i + 1] && old.second[before] == j;
            fresh.first[slot] = i;
            fresh.second[slot] = j;
            fresh.store(slot, known ? old.history(before) : ContactHistory<Real>{});
            team.claim(&list.incoming_row[j]);
            ++slot;
        });
    });
    team.sync();
    team.scan(n, list.incoming_row);
    team.each(n, [&](Index j) { list.counter[j] = list.incoming_row[j]; });
    team.sync();
    team.each(fresh.row[n], [&](Index slot) { list.incoming[team.claim(&list.counter[fresh.second[slot]])] = slot; });
    team.sync();
    team.each(n, [&](Index j) {
        sort_ascending(list.incoming + list.incoming_row[j], list.incoming + list.incoming_row[j + 1]);
        list.near_reference.set(j, particles.fractional[j]);
    });
    team.sync();
    exchange(list.slots, list.spare);
    list.near_edges = cell.edges;
    list.near_valid = true;
    list.travel = 0;
    ++list.near_rebuilds;
    return NeighbourStatus::ready;
}

// Makes sure that every pair which touches at the present positions has a slot.
template <class Team, class Real>
NeighbourStatus update_neighbours(const Team& team, Neighbours<Real>& list, const Particles<Real>& particles, const Cell<Real>& cell) {
    const auto near_is_enough = [&] {
        return list.near_valid && closing(list, cell, list.near_edges, list.travel) < list.near_gap;
    };
    if (near_is_enough()) return NeighbourStatus::ready;
    if (list.near_valid) {
        // `travel` adds up largest velocities, an upper bound: look at the particles themselves before rebuilding.
        list.travel = furthest_travel(team, particles, cell, list.near_reference);
        const Real worth_keeping = Real(0.8) * list.near_gap;
        if (closing(list, cell, list.near_edges, list.travel) < worth_keeping) return NeighbourStatus::ready;
    }
    const auto outer_is_enough = [&] {
        const Real travel = furthest_travel(team, particles, cell, list.outer_reference);
        return closing(list, cell, list.outer_edges, travel) + list.near_gap < list.outer_gap;
    };
    if (!list.outer_valid || !outer_is_enough()) {
        const NeighbourStatus status = rebuild_outer(team, list, particles, cell);
        if (status != NeighbourStatus::ready) return status;
    }
    return rebuild_near(team, list, particles, cell);
}

}  // namespace graincal
