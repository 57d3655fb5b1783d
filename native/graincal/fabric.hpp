// Fabric of a state: mechanical coordination number and the anisotropies of contact normals and forces.
// Source: Hartmann, Cheng, Thornton (2022), Eq. 8-11.
#pragma once

#include "measures.hpp"

namespace graincal {

struct Fabric {
    Coordinate coordination_number = 0;    // Z = (2C - N1) / (N - N0 - N1)
    Coordinate a_c = 0, a_n = 0, a_t = 0;  // of contact normals, normal forces, tangential forces
    Coordinate contacts = 0;               // C
};

struct ContactCensus {
    Index rattlers = 0, singly_held = 0;  // N0, N1
    constexpr ContactCensus& operator+=(const ContactCensus& b) {
        rattlers += b.rattlers, singly_held += b.singly_held;
        return *this;
    }
};

struct ForceFabric {
    Mat3<Coordinate> normal, tangential;
    constexpr ForceFabric& operator+=(const ForceFabric& b) {
        normal += b.normal, tangential += b.tangential;
        return *this;
    }
};

// a* = sign(S) sqrt(3/2 a : a) with S = a : dev sigma.
inline Coordinate signed_anisotropy(const Mat3<Coordinate>& a, const Mat3<Coordinate>& stress_deviator) {
    return sign(double_contraction(a, stress_deviator)) * square_root(1.5 * double_contraction(a, a));
}

template <class Team, class Real, class Law>
Fabric fabric(const Team& team, const Law& law, const Particles<Real>& particles, const Neighbours<Real>& list, const Mat3<Coordinate>& stress) {
    const PairSlots<Real>& slots = list.slots;
    const Index pair_count = slots.row[particles.count];
    const Index contacts = team.sum(pair_count, [&](Index slot) { return Index(slots.touching(slot)); });
    if (contacts == 0) return {};
    team.each(particles.count, [&](Index i) { list.counter[i] = 0; });
    team.sync();
    team.each(pair_count, [&](Index slot) {
        if (!slots.touching(slot)) return;
        team.claim(&list.counter[slots.first[slot]]);
        team.claim(&list.counter[slots.second[slot]]);
    });
    team.sync();
    const auto census = team.sum(particles.count, [&](Index i) -> ContactCensus { return {list.counter[i] == 0, list.counter[i] == 1}; });

    const Coordinate share = 1 / Coordinate(contacts);
    const Mat3<Coordinate> normals = share * team.sum(pair_count, [&](Index slot) -> Mat3<Coordinate> {
        if (!slots.touching(slot)) return {};
        const Vec3<Coordinate> n = as<Coordinate>(slots.normal[slot]);
        return outer(n, n);
    });
    const Mat3<Coordinate> a_c = 7.5 * deviator(normals);
    const ForceFabric forces = team.sum(pair_count, [&](Index slot) -> ForceFabric {
        if (!slots.touching(slot)) return {};
        const Vec3<Coordinate> n = as<Coordinate>(slots.normal[slot]), shear = as<Coordinate>(slots.shear[slot]);
        const Coordinate density = 1 + dot(n, a_c * n), tangential_force = norm(shear);
        const Coordinate normal_force = dot(as<Coordinate>(contact_force(law, particles, slots, slot)), n);
        const Vec3<Coordinate> t = tangential_force > 0 ? (1 / tangential_force) * shear : Vec3<Coordinate>{};
        return {(share * normal_force / density) * outer(n, n), (share * tangential_force / density) * outer(t, n)};
    });
    const Coordinate mean_force = trace(forces.normal);
    const Mat3<Coordinate> a_n = (7.5 / mean_force) * deviator(forces.normal);
    const Mat3<Coordinate> a_t = (5 / mean_force) * deviator(forces.tangential);

    const Mat3<Coordinate> stress_deviator = deviator(stress);
    const Coordinate held = Coordinate(particles.count - census.rattlers - census.singly_held);
    return {held > 0 ? Coordinate(2 * contacts - census.singly_held) / held : 0, signed_anisotropy(a_c, stress_deviator),
            signed_anisotropy(a_n, stress_deviator), signed_anisotropy(a_t, stress_deviator), Coordinate(contacts)};
}

}  // namespace graincal
