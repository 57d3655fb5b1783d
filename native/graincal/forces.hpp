// The two passes over which forces are found: over the near pairs, each into its own slot, and over the particles, each summing its slots.
#pragma once

#include "cell.hpp"
#include "contacts.hpp"
#include "neighbours.hpp"
#include "particles.hpp"

namespace graincal {

// Brings every near pair's contact to the present positions and writes its forces to its slot. Pairs that do not touch are computed too and
// given zeros: there are few of them, and without a branch the loop becomes vector code.
template <class Team, class Real, class Law>
void pair_pass(const Team& team, const Law& law, const Cell<Real>& cell, const Particles<Real>& particles, const PairSlots<Real>& slots,
               const PairForces<Real>& out, Real dt) {
    // The latest motion took branch b to (1 + dt L) b + dt (u2 - u1): seen from its end, v2 - v1 = u2 - u1 + G (branch - dt (u2 - u1)).
    const Mat3<Real> gradient = cell.velocity_gradient * inverse(Mat3<Real>::identity() + dt * cell.velocity_gradient);
    team.each(slots.row[particles.count], [=](Index slot) {
        const Index i = slots.first[slot], j = slots.second[slot];
        const Vec3<Real> branch = cell.branch(particles.fractional[i], particles.fractional[j]);
        const Vec3<Real> fluctuation = particles.velocity[j] - particles.velocity[i];
        const Real radius1 = particles.radius[i], radius2 = particles.radius[j];
        const Real distance = norm(branch), overlap = radius1 + radius2 - distance;
        const TouchingPair<Real> pair{radius1,
                                      radius2,
                                      overlap,
                                      (Real(1) / distance) * branch,
                                      fluctuation + gradient * (branch - dt * fluctuation),
                                      particles.spin[i],
                                      particles.spin[j]};
        const ContactStiffness<Real> stiffness = law.stiffness(pair);
        const Real normal_force = law.normal_force(pair, stiffness);
        const ContactHistory<Real> history = law.advance(pair, stiffness, normal_force, dt, slots.history(slot));
        slots.store(slot, history);

        const bool touches = overlap >= Real(0);
        const auto if_touching = [=](const Vec3<Real>& v) { return either(touches, v, {}); };
        const Vec3<Real> force = normal_force * pair.normal + history.shear;
        const Vec3<Real> moment = history.bending + history.twisting;
        const Vec3<Real> lever = cross(pair.normal, history.shear);
        out.force.set(slot, if_touching(force));
        out.torque1.set(slot, if_touching(-((radius1 - Real(0.5) * overlap) * lever + moment)));
        out.torque2.set(slot, if_touching(moment - (radius2 - Real(0.5) * overlap) * lever));
        out.virial.set(slot, if_touching(componentwise(force, branch)));
        const Real counts = touches ? Real(1) : Real(0);
        out.store_stiffness(slot, {counts * stiffness.normal, counts * stiffness.shear, counts * stiffness.rolling});
    });
}

// Sums forces and torques, and finds for each particle the largest of K/m and R/I, 1/s^2: the squared frequency that bounds the time step.
// K_a = sum (kn - ks) n_a^2 + ks and R_a = sum ks r^2 (1 - n_a^2) + km per axis a, as YADE's GlobalStiffnessTimeStepper.
template <class Team, class Real>
void gather_pass(const Team& team, const Particles<Real>& particles, const Neighbours<Real>& list, const PairForces<Real>& pairs) {
    team.each(particles.count, [=, &list](Index i) {
        Vec3<Real> force, torque, translation, shear_across;
        Real rolling = 0;
        const auto add_stiffness = [&](Index slot) {
            const ContactStiffness<Real> k = pairs.stiffness(slot);
            const Vec3<Real> n = list.slots.normal[slot], squared = componentwise(n, n);
            translation += (k.normal - k.shear) * squared + Vec3<Real>{k.shear, k.shear, k.shear};
            shear_across += k.shear * (Vec3<Real>{1, 1, 1} - squared);
            rolling += k.rolling;
        };
        for (Index slot = list.slots.row[i]; slot < list.slots.row[i + 1]; ++slot) {
            force -= pairs.force[slot];
            torque += pairs.torque1[slot];
            add_stiffness(slot);
        }
        for (Index k = list.incoming_row[i]; k < list.incoming_row[i + 1]; ++k) {
            const Index slot = list.incoming[k];
            force += pairs.force[slot];
            torque += pairs.torque2[slot];
            add_stiffness(slot);
        }
        particles.force.set(i, force);
        particles.torque.set(i, torque);
        const Real r = particles.radius[i], rotation = r * r * largest(shear_across) + rolling;
        particles.squared_frequency[i] = maximum(largest(translation) * particles.inverse_mass[i], rotation * particles.inverse_inertia[i]);
    });
}

}  // namespace graincal
