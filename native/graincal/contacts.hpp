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

// What the force pass writes for the gather pass to sum.
template <class Real> struct PairForces {
    Vec3Array<Real> force;             // on the second particle; the first takes the opposite
    Vec3Array<Real> torque1, torque2;  // on the first and on the second
    Vec3Array<Real> virial;            // the diagonal of force (x) branch
    Real *normal_stiffness, *shear_stiffness, *rolling_stiffness;

    void lay_out(Arena& arena, Index capacity) {
        force = arena.take_vectors<Real>(capacity);
        torque1 = arena.take_vectors<Real>(capacity);
        torque2 = arena.take_vectors<Real>(capacity);
        virial = arena.take_vectors<Real>(capacity);
        normal_stiffness = arena.take<Real>(capacity);
        shear_stiffness = arena.take<Real>(capacity);
        rolling_stiffness = arena.take<Real>(capacity);
    }
    ContactStiffness<Real> stiffness(Index slot) const { return {normal_stiffness[slot], shear_stiffness[slot], rolling_stiffness[slot]}; }
    void store_stiffness(Index slot, const ContactStiffness<Real>& k) const {
        normal_stiffness[slot] = k.normal;
        shear_stiffness[slot] = k.shear;
        rolling_stiffness[slot] = k.rolling;
    }
};

}  // namespace graincal
