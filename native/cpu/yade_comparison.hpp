// What YADE does differently, to compare with it step by step. Not for use: its fluctuation depends on where the origin lies.
//
// YADE's bodies carry v = u + L x with x before the latest motion. Its NewtonIntegrator takes the fluctuation that damping opposes as v - L x with
// x after that motion, and adds dt L v to v with the new time step, where the old one would leave u alone.
#pragma once

#include <vector>

#include "graincal/simulation.hpp"

namespace graincal {

template <class Real> class YadeMotion {
  public:
    // The motion that led to the present positions.
    template <class Sim> void remember(const Sim& sim) {
        gradient_ = sim.cell.velocity_gradient;
        time_step_ = sim.steps == 0 ? 0.0 : sim.time_step;
    }

    template <class Team, class Sim> Status move(const Team& team, Sim& sim) {
        const auto before = gradient_ * inverse(Mat3<Coordinate>::identity() + time_step_ * gradient_);
        opposed_.resize(sim.particles.count);
        for (Index i = 0; i < sim.particles.count; ++i) {
            const Vec3<Coordinate> u = as<Coordinate>(sim.particles.velocity[i]), x = sim.cell.edges * sim.particles.fractional[i];
            const Vec3<Coordinate> v = u + before * (x - time_step_ * u);
            opposed_[i] = as<Real>(v - gradient_ * x);
            if (sim.steps > 0) sim.particles.velocity.set(i, as<Real>(u + (sim.time_step - time_step_) * (gradient_ * v)));
        }
        return graincal::move(team, sim, [this](Index i, const Vec3<Real>&) { return opposed_[i]; });
    }

  private:
    Mat3<Coordinate> gradient_{};
    Coordinate time_step_ = 0;
    std::vector<Vec3<Real>> opposed_;
};

}  // namespace graincal
