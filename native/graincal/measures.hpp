// What a state is judged by and reported with: stress, unbalanced force, energies.
#pragma once

#include "forces.hpp"

namespace graincal {

// Contact stress (1/V) sum f (x) branch, Pa; compression positive.
template <class Team, class Real>
Mat3<Real> stress_tensor(const Team& team, const Cell<Real>& cell, const Particles<Real>& particles, const PairSlots<Real>& slots,
                         const PairForces<Real>& pairs) {
    const Mat3<Real> sum = team.sum(slots.row[particles.count], [&](Index slot) -> Mat3<Real> {
        if (!slots.touching(slot)) return {};
        const Real distance = particles.radius[slots.first[slot]] + particles.radius[slots.second[slot]] - slots.overlap[slot];
        return outer(pairs.force[slot], distance * slots.normal[slot]);
    });
    return (Real(1) / cell.volume()) * sum;
}

template <class Real> struct SumAndCount {
    Real sum = 0;
    Index count = 0;
    constexpr SumAndCount& operator+=(const SumAndCount& b) {
        sum += b.sum, count += b.count;
        return *this;
    }
};

// Mean over particles of |sum F| over mean over contacts of |F|; infinite without contacts.
template <class Team, class Real>
Real unbalanced_force(const Team& team, const Particles<Real>& particles, const PairSlots<Real>& slots, const PairForces<Real>& pairs) {
    const auto contacts = team.sum(slots.row[particles.count], [&](Index slot) -> SumAndCount<Real> {
        return {norm(pairs.force[slot]), slots.touching(slot) ? 1 : 0};
    });
    if (contacts.count == 0) return infinity<Real>();
    const Real resultant = team.sum(particles.count, [&](Index i) { return norm(particles.force[i]); });
    return (resultant / Real(particles.count)) / (contacts.sum / Real(contacts.count));
}

template <class Team, class Real> Real kinetic_energy(const Team& team, const Particles<Real>& particles) {
    return team.sum(particles.count, [&](Index i) {
        const Vec3<Real> u = particles.velocity[i], w = particles.spin[i];
        return Real(0.5) * (dot(u, u) / particles.inverse_mass[i] + dot(w, w) / particles.inverse_inertia[i]);
    });
}

template <class Team, class Real, class Law>
Real elastic_energy(const Team& team, const Law& law, const Particles<Real>& particles, const PairSlots<Real>& slots, const PairForces<Real>& pairs) {
    return team.sum(slots.row[particles.count], [&](Index slot) {
        return slots.touching(slot) ? law.elastic_energy(pairs.stiffness(slot), slots.history(slot)) : Real(0);
    });
}

template <class Team, class Real> Real solid_volume(const Team& team, const Particles<Real>& particles) {
    constexpr Real four_thirds_pi = Real(4.18879020478639098461685784437267);
    return four_thirds_pi * team.sum(particles.count, [&](Index i) {
        const Real r = particles.radius[i];
        return r * r * r;
    });
}

}  // namespace graincal
