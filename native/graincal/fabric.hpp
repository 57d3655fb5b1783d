// Fabric of a state: mechanical coordination number and the anisotropies of contact normals and forces.
// Source: Hartmann, Cheng, Thornton (2022), Eq. 8-11.
#pragma once

#include "measures.hpp"

namespace graincal {

template <class Real> struct Fabric {
    Real coordination_number = 0;   // Z = (2C - N1) / (N - N0 - N1)
    Real a_c = 0, a_n = 0, a_t = 0; // of contact normals, normal forces, tangential forces
    Real contacts = 0;              // C
};

template <class Real> struct ContactCensus {
    Index rattlers = 0, singly_held = 0;  // N0, N1
    constexpr ContactCensus& operator+=(const ContactCensus& b) {
        rattlers += b.rattlers, singly_held += b.singly_held;
        return *this;
    }
};

template <class Real> struct ForceFabric {
    Mat3<Real> normal, tangential;
    constexpr ForceFabric& operator+=(const ForceFabric& b) {
        normal += b.normal, tangential += b.tangential;
        return *this;
    }
};

// a* = sign(S) sqrt(3/2 a : a) with S = a : dev sigma.
template <class Real> Real signed_anisotropy(const Mat3<Real>& a, const Mat3<Real>& stress_deviator) {
    return sign(double_contraction(a, stress_deviator)) * square_root(Real(1.5) * double_contraction(a, a));
}

template <class Team, class Real>
Fabric<Real> fabric(const Team& team, const Particles<Real>& particles, const Neighbours<Real>& list, const Mat3<Real>& stress, const PairForces<Real>& pairs) {
    const PairSlots<Real>& slots = list.slots;
    const Index pair_count = slots.row[particles.count];
    const Index contacts = team.sum(pair_count, [&](Index slot) { return Index(slots.touching(slot)); });
    if (contacts == 0) return {};
    const auto census = team.sum(particles.count, [&](Index i) -> ContactCensus<Real> {
        Index touching = 0;
        for (Index slot = slots.row[i]; slot < slots.row[i + 1]; ++slot) touching += slots.touching(slot);
        for (Index k = list.incoming_row[i]; k < list.incoming_row[i + 1]; ++k) touching += slots.touching(list.incoming[k]);
        return {touching == 0, touching == 1};
    });

    const Real share = Real(1) / Real(contacts);
    const Mat3<Real> normals = share * team.sum(pair_count, [&](Index slot) -> Mat3<Real> {
        if (!slots.touching(slot)) return {};
        return outer(slots.normal[slot], slots.normal[slot]);
    });
    const Mat3<Real> a_c = Real(7.5) * deviator(normals);
    const ForceFabric<Real> forces = team.sum(pair_count, [&](Index slot) -> ForceFabric<Real> {
        if (!slots.touching(slot)) return {};
        const Vec3<Real> n = slots.normal[slot], shear = slots.shear[slot];
        const Real density = Real(1) + dot(n, a_c * n), tangential_force = norm(shear);
        const Real normal_force = dot(pairs.force[slot], n);
        const Vec3<Real> t = tangential_force > Real(0) ? (Real(1) / tangential_force) * shear : Vec3<Real>{};
        return {(share * normal_force / density) * outer(n, n), (share * tangential_force / density) * outer(t, n)};
    });
    const Real mean_force = trace(forces.normal);
    const Mat3<Real> a_n = (Real(7.5) / mean_force) * deviator(forces.normal);
    const Mat3<Real> a_t = (Real(5) / mean_force) * deviator(forces.tangential);

    const Mat3<Real> stress_deviator = deviator(stress);
    const Real held = Real(particles.count - census.rattlers - census.singly_held);
    return {held > Real(0) ? Real(2 * contacts - census.singly_held) / held : Real(0), signed_anisotropy(a_c, stress_deviator),
            signed_anisotropy(a_n, stress_deviator), signed_anisotropy(a_t, stress_deviator), Real(contacts)};
}

}  // namespace graincal
