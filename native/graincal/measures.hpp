// What a state is judged by and reported with: stress, unbalanced force, energies.
#pragma once

#include "forces.hpp"

namespace graincal {

// Contact stress (1/V) sum f (x) branch, Pa; compression positive.
template <class Team, class Real, class Law>
Mat3<Coordinate> stress_tensor(const Team& team, const Law& law, const Cell& cell, const Particles<Real>& particles, const PairSlots<Real>& slots) {
    const Mat3<Coordinate> sum = team.sum(slots.row[particles.count], [&](Index slot) -> Mat3<Coordinate> {
        if (!slots.touching(slot)) return {};
        const Coordinate distance = particles.radius[slots.first[slot]] + particles.radius[slots.second[slot]] - Coordinate(slots.overlap[slot]);
        return outer(as<Coordinate>(contact_force(law, particles, slots, slot)), distance * as<Coordinate>(slots.normal[slot]));
    });
    return (1 / cell.volume()) * sum;
}

struct SumAndCount {
    Coordinate sum = 0;
    Index count = 0;
    constexpr SumAndCount& operator+=(const SumAndCount& b) {
        sum += b.sum, count += b.count;
        return *this;
    }
};

// Mean over particles of |sum F| over mean over contacts of |F|; infinite without contacts.
template <class Team, class Real, class Law>
Coordinate unbalanced_force(const Team& team, const Law& law, const Particles<Real>& particles, const PairSlots<Real>& slots) {
    const auto contacts = team.sum(slots.row[particles.count], [&](Index slot) -> SumAndCount {
        if (!slots.touching(slot)) return {};
        return {Coordinate(norm(contact_force(law, particles, slots, slot))), 1};
    });
    if (contacts.count == 0) return infinity<Coordinate>();
    const Coordinate resultant = team.sum(particles.count, [&](Index i) { return Coordinate(norm(particles.load[i].force)); });
    return (resultant / particles.count) / (contacts.sum / contacts.count);
}

template <class Team, class Real> Coordinate kinetic_energy(const Team& team, const Particles<Real>& particles) {
    return team.sum(particles.count, [&](Index i) {
        const Vec3<Real> u = particles.velocity[i], w = particles.spin[i];
        return Coordinate(Real(0.5) * (dot(u, u) / particles.inverse_mass[i] + dot(w, w) / particles.inverse_inertia[i]));
    });
}

template <class Team, class Real, class Law>
Coordinate elastic_energy(const Team& team, const Law& law, const Particles<Real>& particles, const PairSlots<Real>& slots) {
    return team.sum(slots.row[particles.count], [&](Index slot) {
        const bool touches = slots.touching(slot);
        return touches ? Coordinate(law.elastic_energy(law.stiffness(resting_pair(particles, slots, slot)), slots.history(slot))) : Coordinate(0);
    });
}

template <class Team, class Real> Coordinate solid_volume(const Team& team, const Particles<Real>& particles) {
    constexpr Coordinate four_thirds_pi = 4.18879020478639098461685784437267;
    return four_thirds_pi * team.sum(particles.count, [&](Index i) {
        const Coordinate r = particles.radius[i];
        return r * r * r;
    });
}

}  // namespace graincal
