// The spheres: where they are, how they move, what acts on them.
#pragma once

#include "memory.hpp"

namespace graincal {

// A particle as a pair sees it.
template <class Real> struct PairSide {
    Vec3<Coordinate> fractional;
    Coordinate radius;
    Vec3<Real> velocity, spin;  // the velocity is the fluctuation
};

// What a pass over the pairs sums for each particle is a record of eight numbers, so that a team can add it as vectors of four.
// `number` hands a record's parts on one by one, with their places: a team may keep records of many pairs as columns.

// What acts on a particle; and how stiffly it is held at most, in translation and in rotation, whichever way its contacts point.
template <class Real> struct alignas(8 * sizeof(Real)) Load {
    Vec3<Real> force, torque;
    Real translation{}, rotation{};

    using Number = Real;
    template <class Take> static void number(Take take, const Vec3<Real>& force, const Vec3<Real>& torque, Real translation, Real rotation) {
        take(0, force.x), take(1, force.y), take(2, force.z), take(3, torque.x), take(4, torque.y), take(5, torque.z);
        take(6, translation), take(7, rotation);
    }
    Load& operator+=(const Load& b) {
        force += b.force, torque += b.torque, translation += b.translation, rotation += b.rotation;
        return *this;
    }
};

// Sums over a particle's contacts from which its critical time step follows: of (kn - ks) n_a^2, ks n_a^2, ks, km.
template <class Real> struct alignas(8 * sizeof(Real)) StiffnessSum {
    Vec3<Real> normal_less_shear, shear_along;
    Real shear{}, rolling{};

    using Number = Real;
    template <class Take> static void number(Take take, const Vec3<Real>& normal_less_shear, const Vec3<Real>& shear_along, Real shear, Real rolling) {
        take(0, normal_less_shear.x), take(1, normal_less_shear.y), take(2, normal_less_shear.z);
        take(3, shear_along.x), take(4, shear_along.y), take(5, shear_along.z), take(6, shear), take(7, rolling);
    }
    StiffnessSum& operator+=(const StiffnessSum& b) {
        normal_less_shear += b.normal_less_shear, shear_along += b.shear_along, shear += b.shear, rolling += b.rolling;
        return *this;
    }
};

// Room for a team of one thread to lay a particle out in lines of memory of its own: fractional coordinates and radius; velocity, spin and two unused.
template <class Real> struct alignas(32) Line {
    Coordinate place[4];
    Real motion[8];
};

template <class Real> struct Particles {
    Index count = 0;
    Vec3Array<Coordinate> fractional;  // s = H^-1 x, never wrapped: a difference is taken to its nearest image instead
    Vec3Array<Real> velocity;          // u = v - L x, the fluctuation about the cell's motion
    Vec3Array<Real> spin;
    Coordinate* radius;
    Real* inverse_mass;
    Real* inverse_inertia;  // of a sphere, 2/5 m r^2
    Load<Real>* load;
    StiffnessSum<Real>* stiffness;
    Real* squared_frequency;  // of each particle alone, 1/s^2, where the time step's bound looks at pairs
    Line<Real>* line;
    Index* given;  // the place in the packing as it was given: here particles are sorted in space

    void lay_out(Arena& arena, Index n) {
        count = n;
        fractional = arena.take_vectors<Coordinate>(n);
        velocity = arena.take_vectors<Real>(n);
        spin = arena.take_vectors<Real>(n);
        radius = arena.take<Coordinate>(n);
        inverse_mass = arena.take<Real>(n);
        inverse_inertia = arena.take<Real>(n);
        load = arena.take<Load<Real>>(n);
        stiffness = arena.take<StiffnessSum<Real>>(n);
        squared_frequency = arena.take<Real>(n);
        line = arena.take<Line<Real>>(n);
        given = arena.take<Index>(n);
    }
    PairSide<Real> side(Index i) const { return {fractional[i], radius[i], velocity[i], spin[i]}; }
};

// What one pair adds: to the sums of its first and of its second particle, and to a sum over all pairs.
template <class Sum> struct PairTerms {
    Sum to_first, to_second;
    Vec3<typename Sum::Number> to_all;
};

// The near pairs by their particles: pair k is that of first[k] and second[k].
struct PairEnds {
    Index count;
    const Index *first, *second;
    // For teams that look up what the pairs add to a particle: those of which i is the first are row[i] to row[i + 1], those of which it is the second
    // are listed from incoming[incoming_row[i]] on. `landing` has room for the terms of every pair.
    const Index *row, *incoming_row, *incoming;
    char* landing;
};

}  // namespace graincal
