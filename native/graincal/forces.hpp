// The two passes over which forces are found: over the near pairs, each into its own slot, and over the particles, each summing its slots.
#pragma once

#include "cell.hpp"
#include "contacts.hpp"
#include "neighbours.hpp"
#include "particles.hpp"

namespace graincal {

// What a force pass returns besides the slots: the diagonal of sum f (x) branch, N m. Divided by the volume it is the stress.
template <class Team, class Real, class Law>
Vec3<Real> pair_pass(const Team& team, const Law& law, const Cell<Real>& cell, const Particles<Real>& particles, const PairSlots<Real>& slots,
                     const PairForces<Real>& out, Real dt) {
    const Index pairs = slots.row[particles.count];
    // The latest motion took branch b to (1 + dt L) b + dt (u2 - u1): seen from its end, v2 - v1 = u2 - u1 + G (branch - dt (u2 - u1)).
    const Mat3<Real> gradient = cell.velocity_gradient * inverse(Mat3<Real>::identity() + dt * cell.velocity_gradient);
    return team.sum(pairs, [&](Index slot) -> Vec3<Real> {
        const Index i = slots.first[slot], j = slots.second[slot];
        const Vec3<Real> branch = cell.branch(particles.fractional[i], particles.fractional[j]);
        const Real radius1 = particles.radius[i], radius2 = particles.radius[j];
        const Real squared = dot(branch, branch), contact_distance = radius1 + radius2;
        if (squared > contact_distance * contact_distance) {
            slots.overlap[slot] = Real(-1);
            out.force.set(slot, {});
            out.torque1.set(slot, {});
            out.torque2.set(slot, {});
            out.store_stiffness(slot, {});
            return {};
        }
        const Real distance = square_root(squared);
        const Vec3<Real> fluctuation = particles.velocity[j] - particles.velocity[i];
        const TouchingPair<Real> pair{radius1,
                                      radius2,
                                      contact_distance - distance,
                                      (Real(1) / distance) * branch,
                                      fluctuation + gradient * (branch - dt * fluctuation),
                                      particles.spin[i],
                                      particles.spin[j]};
        const ContactStiffness<Real> stiffness = law.stiffness(pair);
        ContactHistory<Real> history = slots.history(slot);
        const Real normal_force = law.evaluate(pair, stiffness, dt, history);
        slots.store(slot, history);

        const Vec3<Real> force = normal_force * pair.normal + history.shear;
        const Vec3<Real> moment = history.bending + history.twisting;
        const Vec3<Real> lever = cross(pair.normal, history.shear);
        out.force.set(slot, force);
        out.torque1.set(slot, -((radius1 - Real(0.5) * pair.overlap) * lever + moment));
        out.torque2.set(slot, moment - (radius2 - Real(0.5) * pair.overlap) * lever);
        out.store_stiffness(slot, stiffness);
        return componentwise(force, branch);
    });
}

// Sums each particle's slots: those of its own row, then those that come in from other rows, slots ascending in both.
template <class Real, class F> void each_slot_of(Index i, const Neighbours<Real>& list, F f) {
    for (Index slot = list.slots.row[i]; slot < list.slots.row[i + 1]; ++slot) f(slot, true);
    for (Index k = list.incoming_row[i]; k < list.incoming_row[i + 1]; ++k) f(list.incoming[k], false);
}

template <class Team, class Real>
void gather_pass(const Team& team, const Particles<Real>& particles, const Neighbours<Real>& list, const PairForces<Real>& pairs) {
    team.each(particles.count, [&](Index i) {
        Vec3<Real> force, torque;
        each_slot_of(i, list, [&](Index slot, bool is_first) {
            if (is_first) {
                force -= pairs.force[slot];
                torque += pairs.torque1[slot];
            } else {
                force += pairs.force[slot];
                torque += pairs.torque2[slot];
            }
        });
        particles.force.set(i, force);
        particles.torque.set(i, torque);
    });
}

}  // namespace graincal
