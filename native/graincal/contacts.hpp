// Slots of near pairs: each holds the pair, the contact's history, and what the latest force pass found.
#pragma once

#include "contact.hpp"
#include "memory.hpp"

namespace graincal {

// Near pairs in rows of their first particle, seconds ascending within a row.
template <class Real> struct PairSlots {
    Index* row;  // (N + 1): slots row[i] to row[i + 1] have first particle i
    Index *first, *second;
    Real* overlap;
    Vec3Array<Real> normal, shear, bending, twisting;

    void lay_out(Arena& arena, Index particles, Index capacity) {
        row = arena.take<Index>(particles + 1);
        first = arena.take<Index>(capacity);
        second = arena.take<Index>(capacity);
        overlap = arena.take<Real>(capacity);
        normal = arena.take_vectors<Real>(capacity);
        shear = arena.take_vectors<Real>(capacity);
        bending = arena.take_vectors<Real>(capacity);
        twisting = arena.take_vectors<Real>(capacity);
    }
    // f(column, none) for each of the numbers that a contact remembers, and what it is for a pair without a history.
    template <class F> void each_column(F f) {
        const ContactHistory<Real> none;
        f(overlap, none.overlap);
        const auto vectors = [&](Vec3Array<Real>& v) { f(v.x, Real(0)), f(v.y, Real(0)), f(v.z, Real(0)); };
        vectors(normal), vectors(shear), vectors(bending), vectors(twisting);
    }
    // Asks ahead for what the pair of this slot remembers.
    [[gnu::always_inline]] inline void fetch(Index slot) const {
        fetch_ahead(overlap + slot);
        fetch_ahead(normal, slot), fetch_ahead(shear, slot), fetch_ahead(bending, slot), fetch_ahead(twisting, slot);
    }
    bool touching(Index slot) const { return overlap[slot] >= Real(0); }
    ContactHistory<Real> history(Index slot) const { return {overlap[slot], normal[slot], shear[slot], bending[slot], twisting[slot]}; }
    void store(Index slot, const ContactHistory<Real>& h) const {
        overlap[slot] = h.overlap;
        normal.set(slot, h.normal);
        shear.set(slot, h.shear);
        bending.set(slot, h.bending);
        twisting.set(slot, h.twisting);
    }
};

}  // namespace graincal
