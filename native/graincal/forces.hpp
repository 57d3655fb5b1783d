// The passes over the near pairs: one finds the forces on the particles, one the stiffnesses that bound the time step.
#pragma once

#include "cell.hpp"
#include "contacts.hpp"
#include "neighbours.hpp"

namespace graincal {

// Brings every near pair's contact to the present positions, sums what acts on each particle, and returns the diagonal of the sum of force (x) branch.
// Pairs that do not touch are computed too, with no force: there are few of them, and without a branch the loop becomes vector code.
// `edges` are those of the cell, `gradient` is G below; both Mat3, or Diagonal where they are.
template <class Team, class Real, class Law, class Matrix>
Vec3<Coordinate> force_pass(const Team& team, const Law& law, const Matrix& edges, const Matrix& exact_gradient, const Particles<Real>& particles,
                            const Neighbours<Real>& list, Coordinate time_step) {
    const auto gradient = as<Real>(exact_gradient);
    const Real dt = Real(time_step);
    const PairSlots<Real> slots = list.slots;
    return team.over_pairs(
        list.ends(), slots, particles, particles.load, [=](Index slot, const PairSide<Real>& one, const PairSide<Real>& two, auto to_first, auto to_second) {
            const Vec3<Coordinate> exact_branch = edges * Cell::nearest_image(two.fractional - one.fractional);
            const Coordinate distance = norm(exact_branch), reach = one.radius + two.radius;
            const Real radius1 = Real(one.radius), radius2 = Real(two.radius), overlap = Real(reach - distance), share = Real(1) / Real(distance);
            const Vec3<Real> branch = as<Real>(exact_branch), fluctuation = two.velocity - one.velocity;
            const Vec3<Real> relative_velocity = fluctuation + gradient * (branch - dt * fluctuation);
            const TouchingPair<Real> pair{radius1, radius2, overlap, Real(reach) * share, share * branch, relative_velocity, one.spin, two.spin};
            const ContactStiffness<Real> stiffness = law.stiffness(pair);
            const Real normal_force = law.normal_force(pair, stiffness);
            const ContactHistory<Real> history = law.advance(pair, stiffness, normal_force, dt, slots.history(slot));
            slots.store(slot, history);

            const Vec3<Real> force = normal_force * pair.normal + history.shear;
            const Vec3<Real> moment = history.bending + history.twisting;
            const Vec3<Real> lever = cross(pair.normal, history.shear);
            const Vec3<Real> torque1 = (radius1 - Real(0.5) * overlap) * lever + moment, torque2 = moment - (radius2 - Real(0.5) * overlap) * lever;
            const Real counts = overlap >= Real(0) ? Real(1) : Real(0);
            const Real translation = counts * maximum(stiffness.normal, stiffness.shear);
            const auto rotation = [&](Real radius) { return counts * (stiffness.shear * radius * radius + stiffness.rolling); };
            to_first(-force, -torque1, translation, rotation(radius1));
            to_second(force, torque2, translation, rotation(radius2));
            return componentwise(force, branch);
        });
}

template <class Team, class Real, class Law>
Vec3<Coordinate> find_pair_forces(const Team& team, const Law& law, const Cell& cell, const Particles<Real>& particles, const Neighbours<Real>& list,
                                  Coordinate time_step) {
    using Matrix = Mat3<Coordinate>;
    // The latest motion took branch b to (1 + dt L) b + dt (u2 - u1): seen from its end, v2 - v1 = u2 - u1 + G (branch - dt (u2 - u1)).
    const Matrix gradient = cell.velocity_gradient * inverse(Matrix::identity() + time_step * cell.velocity_gradient);
    // Most cells only stretch along their axes, which saves twelve multiplications and as many additions a pair.
    if (is_diagonal(cell.edges) && is_diagonal(gradient)) {
        using Stretch = Diagonal<Coordinate>;
        return force_pass(team, law, Stretch::of(cell.edges), Stretch::of(gradient), particles, list, time_step);
    }
    return force_pass(team, law, cell.edges, gradient, particles, list, time_step);
}

// A pair as the latest force pass left it, for what depends on its radii, overlap and normal alone.
template <class Real> TouchingPair<Real> resting_pair(const Particles<Real>& particles, const PairSlots<Real>& slots, Index slot) {
    return {
        Real(particles.radius[slots.first[slot]]), Real(particles.radius[slots.second[slot]]), slots.overlap[slot], Real(1), slots.normal[slot], {}, {}, {}};
}

// The force on the second particle of a touching pair at the latest force pass.
template <class Real, class Law> Vec3<Real> contact_force(const Law& law, const Particles<Real>& particles, const PairSlots<Real>& slots, Index slot) {
    const TouchingPair<Real> pair = resting_pair(particles, slots, slot);
    return law.normal_force(pair, law.stiffness(pair)) * pair.normal + slots.shear[slot];
}

template <class Real> struct Weights {
    Real first, second;
};
struct EqualWeights {
    template <class Real> Weights<Real> operator()(const PairSlots<Real>&, Index) const { return {Real(1), Real(1)}; }
};

// Sums the stiffnesses of each particle's contacts, each as much as `weigh` says for its two particles.
template <class Team, class Real, class Law, class Weigh = EqualWeights>
void stiffness_pass(const Team& team, const Law& law, const Particles<Real>& particles, const Neighbours<Real>& list, Weigh weigh = {}) {
    const PairSlots<Real> slots = list.slots;
    team.over_pairs(list.ends(), slots, particles, particles.stiffness,
                    [=](Index slot, const PairSide<Real>& one, const PairSide<Real>& two, auto to_first, auto to_second) {
                        const Vec3<Real> n = slots.normal[slot], squared = componentwise(n, n);
                        const ContactStiffness<Real> k = law.stiffness({Real(one.radius), Real(two.radius), slots.overlap[slot], Real(1), n, {}, {}, {}});
                        const Real counts = slots.touching(slot) ? Real(1) : Real(0), shear = counts * k.shear;
                        const Vec3<Real> normal_less_shear = (counts * (k.normal - k.shear)) * squared, shear_along = shear * squared;
                        const Real rolling = counts * k.rolling;
                        const Weights<Real> w = weigh(slots, slot);
                        to_first(w.first * normal_less_shear, w.first * shear_along, w.first * shear, w.first * rolling);
                        to_second(w.second * normal_less_shear, w.second * shear_along, w.second * shear, w.second * rolling);
                        return Vec3<Real>{};
                    });
}

// No squared frequency of a particle below is larger than this, 1/s^2; found at every force pass.
template <class Team, class Real> Real bound_on_squared_frequency(const Team& team, const Particles<Real>& particles) {
    const Particles<Real> p = particles;
    return team.largest(p.count, [=](Index i) { return maximum(p.load[i].translation * p.inverse_mass[i], p.load[i].rotation * p.inverse_inertia[i]); });
}

// The larger of a particle's K/m and R/I, 1/s^2. Per axis a, K_a = sum (kn - ks) n_a^2 + ks and R_a = sum ks r^2 (1 - n_a^2) + km, as YADE's
// GlobalStiffnessTimeStepper.
template <class Real> Real squared_frequency(const Particles<Real>& particles, Index i) {
    const StiffnessSum<Real> k = particles.stiffness[i];
    const Real r = Real(particles.radius[i]);
    const Real translation = largest(k.normal_less_shear) + k.shear;
    const Real rotation = r * r * (k.shear - minimum(k.shear_along.x, minimum(k.shear_along.y, k.shear_along.z))) + k.rolling;
    return maximum(translation * particles.inverse_mass[i], rotation * particles.inverse_inertia[i]);
}

// The largest over the particles, which bounds the time step. Zero without contacts.
template <class Team, class Real> Real largest_squared_frequency(const Team& team, const Particles<Real>& particles) {
    return team.largest(particles.count, [&](Index i) { return squared_frequency(particles, i); });
}

// Sums the stiffnesses anew, so that the largest squared frequency is what both particles of a contact make of it, and never above what it was.
// The energy of a contact between particles that move by a and b is 1/2 k (a - b)^2 <= 1/2 k ((1 + q) a^2 + (1 + 1/q) b^2) for every q > 0; with q the ratio
// of their squared frequencies t_b / t_a, a pair in contact with each other alone gets t_a + t_b, which is exact, where each for itself gets twice the
// larger. For graphs this is the bound of Anderson and Morley (1985), Linear and Multilinear Algebra 18.
template <class Team, class Real, class Law>
void share_stiffness(const Team& team, const Law& law, const Particles<Real>& particles, const Neighbours<Real>& list) {
    team.each(particles.count, [=](Index i) { particles.squared_frequency[i] = squared_frequency(particles, i); });
    team.sync();
    const Real* alone = particles.squared_frequency;
    const auto half_of_both = [=](Real own, Real other) { return Real(0.5) + Real(0.5) * (own > Real(0) ? other / own : Real(0)); };
    stiffness_pass(team, law, particles, list, [=](const PairSlots<Real>& slots, Index slot) {
        const Real first = alone[slots.first[slot]], second = alone[slots.second[slot]];
        return Weights<Real>{half_of_both(first, second), half_of_both(second, first)};
    });
    team.sync();
}

}  // namespace graincal
