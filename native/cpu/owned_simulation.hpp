// A simulation with the memory that it lives in, on a host: built from a packing, copied whole, sorted in space now and then, given more room when a
// list is full.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "graincal/economy.hpp"
#include "serial_team.hpp"

namespace graincal {

// The particles and their cell; plain arrays in SI units, positions absolute.
struct PackingView {
    std::span<const double> positions;  // (N, 3)
    std::span<const double> radii;      // (N)
    Mat3<double> edges;
    std::size_t count() const { return radii.size(); }
};

// The particles along a Morton curve through meshes about as wide as a grain: who touch are then near in memory too.
// `fractional(i)` are the fractional coordinates of particle i. Those that are not finite come in any place: the neighbour search ends such a simulation.
template <class F> std::vector<Index> order_in_space(Index n, const Mat3<double>& edges, F fractional) {
    constexpr Index bits = 20;  // of a place along an axis
    const double meshes_per_edge = std::cbrt(double(n) / determinant(edges));
    std::vector<std::pair<std::uint64_t, Index>> placed(n);
    for (Index i = 0; i < n; ++i) {
        const Vec3<double> s = fractional(i);
        std::uint64_t key = 0;
        for (Index axis = 0; axis < 3; ++axis) {
            const double place = (s[axis] - std::floor(s[axis])) * meshes_per_edge * edges(axis, axis);
            const auto mesh = static_cast<std::uint64_t>(place >= 0 && place < double(1 << bits) ? place : 0);
            for (Index bit = 0; bit < bits; ++bit) key |= (mesh >> bit & 1) << (3 * bit + axis);
        }
        placed[i] = {key, i};
    }
    std::sort(placed.begin(), placed.end());
    std::vector<Index> order(n);
    for (Index i = 0; i < n; ++i) order[i] = placed[i].second;
    return order;
}

// A near pair by other numbers of its particles, the lower first; reversed where its slot has them the other way round.
struct RenumberedPair {
    Index first, second, slot;
    bool reversed;
};
template <class Real> std::vector<RenumberedPair> renumbered_pairs(const PairSlots<Real>& slots, Index particles, const Index* number) {
    std::vector<RenumberedPair> pairs(slots.row[particles]);
    for (Index slot = 0; slot < slots.row[particles]; ++slot) {
        const Index i = number[slots.first[slot]], j = number[slots.second[slot]];
        pairs[slot] = {std::min(i, j), std::max(i, j), slot, i > j};
    }
    std::sort(pairs.begin(), pairs.end(),
              [](const RenumberedPair& a, const RenumberedPair& b) { return std::pair(a.first, a.second) < std::pair(b.first, b.second); });
    return pairs;
}

// A particle's density over that of all, by its radius, where masses go with a power of it: (r / R)^(exponent - 3), R such that the whole keeps its mass.
inline auto shares_of_density(std::span<const double> radii, double mass_exponent) {
    double volumes = 0, powers = 0;
    for (const double r : radii) volumes += r * r * r, powers += std::pow(r, mass_exponent);
    return [share = volumes / powers, mass_exponent](double r) { return mass_exponent == 3 ? 1.0 : share * std::pow(r, mass_exponent - 3); };
}

template <class Real, class Law> class OwnedSimulation {
  public:
    using State = Simulation<Real, Law>;

    OwnedSimulation(const PackingView& packing, const Law& law, double density, const Economy& economy = {}) {
        const Index n = static_cast<Index>(packing.count());
        allocate(n, 16 * n + 64, 6 * n + 64);
        state.law = law;
        state.cell.edges = state.cell.initial_edges = packing.edges;
        const Mat3<double> to_fractional = inverse(packing.edges);
        double largest = 0, smallest = packing.radii[0], sum = 0, shortest_wave = std::numeric_limits<double>::infinity();
        const auto fractional = [&](Index given) {
            const double* x = &packing.positions[3 * given];
            return to_fractional * Vec3<double>{x[0], x[1], x[2]};
        };
        const std::vector<Index> order = order_in_space(n, packing.edges, fractional);
        const auto share_of_density = shares_of_density(packing.radii, economy.mass_exponent);
        for (Index i = 0; i < n; ++i) {
            const Index given = order[i];
            const double r = packing.radii[given];
            state.particles.given[i] = given;
            state.particles.radius[i] = r;
            const double own_density = share_of_density(r) * density, mass = own_density * (4.0 / 3.0 * 3.14159265358979323846) * r * r * r;
            state.particles.inverse_mass[i] = Real(1 / mass);
            state.particles.inverse_inertia[i] = Real(1 / (economy.inertia_factor * 0.4 * mass * r * r));
            state.particles.fractional.set(i, fractional(given));
            largest = std::max(largest, r);
            smallest = std::min(smallest, r);
            sum += r;
            shortest_wave = std::min(shortest_wave, r * std::sqrt(own_density / law.modulus));
        }
        state.smallest_radius = smallest;
        // Taken while nothing touches: half the shortest time that a stiff wave takes through a grain. The first contact brings a true estimate.
        state.time_step = 0.5 * shortest_wave;
        state.time_stepper.longest = law.longest_step(state.time_step);
        state.neighbours.largest_radius = largest;
        state.neighbours.widest_outer_gap = state.neighbours.outer_gap = outer_gap_share * sum / n;
        state.neighbours.near_gap = near_gap_share * sum / n;
        economy.apply(state);
        state.servo.inertia = servo_inertia_factor * density * std::pow(state.cell.volume(), 2.0 / 3.0);
    }
    // A copy has the particles' motion and the contacts' memory; its neighbour lists and forces are found anew at its first step.
    OwnedSimulation(const OwnedSimulation& other) : OwnedSimulation(other, other.present_order(), other.outer_capacity(), other.near_capacity()) {}
    OwnedSimulation(OwnedSimulation&&) = default;
    OwnedSimulation& operator=(const OwnedSimulation&) = delete;
    OwnedSimulation& operator=(OwnedSimulation&&) = default;

    // Doubles the room of the list that was found full.
    void make_room(Status full) {
        if (std::max(outer_capacity(), near_capacity()) > std::numeric_limits<Index>::max() / 2) throw std::bad_alloc();
        *this = OwnedSimulation(*this, present_order(), outer_capacity() * (full == Status::needs_more_outer_pairs ? 2 : 1),
                                near_capacity() * (full == Status::needs_more_near_pairs ? 2 : 1));
    }

    void sort_in_space() {
        const auto& particles = state.particles;
        const auto order = order_in_space(particles.count, state.cell.edges, [&](Index i) { return particles.fractional[i]; });
        *this = OwnedSimulation(*this, order, outer_capacity(), near_capacity());
    }

    // Follows a path, sorting the particles and making room where the neighbour lists ask for it.
    template <class Advance> Status advance(Advance step) {
        for (;;) {
            switch (const Status status = step()) {
                case Status::needs_sorting:
                    sort_in_space();
                    break;
                case Status::needs_more_outer_pairs:
                case Status::needs_more_near_pairs:
                    make_room(status);
                    break;
                default:
                    return status;
            }
        }
    }

    State state;

    // Gaps of the two neighbour lists as shares of the mean radius: measured to be the cheapest at the paper's test.
    static constexpr double outer_gap_share = 0.60, near_gap_share = 0.02;

  private:
    std::vector<Index> present_order() const {
        std::vector<Index> order(state.particles.count);
        std::iota(order.begin(), order.end(), Index(0));
        return order;
    }
    Index outer_capacity() const { return state.neighbours.outer_capacity; }
    Index near_capacity() const { return state.neighbours.near_capacity; }

    void allocate(Index n, Index outer_pairs, Index near_pairs) {
        Arena measure;
        state.lay_out(measure, n, outer_pairs, near_pairs);
        block_.reset(static_cast<char*>(::operator new(measure.used(), alignment)));
#if defined(__linux__)
        // A pass reads and writes dozens of arrays at once: on small pages, large simulations spend an eighth of their time on looking those up.
        if (measure.used() >= Arena::Size(alignment)) madvise(block_.get(), measure.used(), MADV_HUGEPAGE);
#endif
        std::memset(block_.get(), 0, measure.used());
        Arena arena(block_.get());
        state.lay_out(arena, n, outer_pairs, near_pairs);
    }

    // order[k] is the place in `other` of what becomes particle k.
    OwnedSimulation(const OwnedSimulation& other, const std::vector<Index>& order, Index outer_pairs, Index near_pairs) : state(other.state) {
        allocate(state.particles.count, outer_pairs, near_pairs);
        state.neighbours.outer_valid = state.neighbours.near_valid = false;
        take_particles(other.state.particles, order);
        take_contacts(other.state.neighbours.slots, order);
    }

    void take_particles(const Particles<Real>& from, const std::vector<Index>& order) {
        auto& to = state.particles;
        for (Index k = 0; k < to.count; ++k) {
            const Index i = order[k];
            to.fractional.set(k, from.fractional[i]);
            to.velocity.set(k, from.velocity[i]);
            to.spin.set(k, from.spin[i]);
            to.given[k] = from.given[i];
            to.radius[k] = from.radius[i];
            to.inverse_mass[k] = from.inverse_mass[i];
            to.inverse_inertia[k] = from.inverse_inertia[i];
        }
    }

    void take_contacts(const PairSlots<Real>& from, const std::vector<Index>& order) {
        const Index n = state.particles.count;
        std::vector<Index> place(n);
        for (Index k = 0; k < n; ++k) place[order[k]] = k;
        const auto& to = state.neighbours.slots;
        Index slot = 0;
        for (const RenumberedPair& pair : renumbered_pairs(from, n, place.data())) {
            const ContactHistory<Real> history = from.history(pair.slot);
            ++to.row[pair.first + 1];
            to.first[slot] = pair.first;
            to.second[slot] = pair.second;
            to.store(slot++, pair.reversed ? history.reversed() : history);
        }
        std::partial_sum(to.row, to.row + n + 1, to.row);
    }

    // Of a huge page.
    static constexpr std::align_val_t alignment{1 << 21};

    struct Release {
        void operator()(char* block) const { ::operator delete(block, alignment); }
    };
    std::unique_ptr<char, Release> block_;
};

}  // namespace graincal
