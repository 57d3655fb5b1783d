// A single simulation in Python's hand, a class for each engine.
#include <algorithm>

#include "bindings.hpp"
#include "yade_comparison.hpp"

namespace graincal {
namespace {

// Python has the particles in the order of the packing that it gave, the engine has them sorted in space.
template <class Real, class F> nb::object given_vectors_as_numpy(const Particles<Real>& particles, F vector) {
    std::vector<Index> at(particles.count);
    for (Index i = 0; i < particles.count; ++i) at[particles.given[i]] = i;
    return vectors_as_numpy(particles.count, [&](Index k) { return vector(at[k]); });
}
template <class Real> void set_given_vectors(const Particles<Real>& particles, const Vec3Array<Real>& vectors, const Array2& values) {
    for (Index i = 0; i < particles.count; ++i) {
        const Index k = particles.given[i];
        vectors.set(i, {Real(values(k, 0)), Real(values(k, 1)), Real(values(k, 2))});
    }
}

template <class Sim> std::vector<RenumberedPair> given_pairs(const Sim& sim) {
    return renumbered_pairs(sim.neighbours.slots, sim.particles.count, sim.particles.given);
}

// A single simulation in hand: what tests and the preparation of packings work with.
template <class Engine> class InteractiveSimulation {
  public:
    using Real = typename Engine::Real;
    using GivenLaw = typename Engine::GivenLaw;

    InteractiveSimulation(const Array2& x, const Array1& r, const Matrix& h, const GivenLaw& law, double density, const Economy& economy)
        : owned_(HeldPacking(x, r, h), law.template in_precision<Real>(), density, economy) {}

    OwnedSimulation<Real, typename Engine::Law> owned_;

    auto& state() { return owned_.state; }

    // Steps with a velocity gradient and a time step that are given: no servo, no stepper.
    void run_prescribed(long long steps, const Matrix& velocity_gradient, double time_step, double damping) {
        const Mat3<double> gradient = as_matrix(velocity_gradient);
        nb::gil_scoped_release release;
        state().time_step = time_step;
        state().damping = damping;
        for (long long step = 0; step < steps; ++step) {
            expect_running(owned_.advance([&] { return find_forces(SerialTeam{}, state()); }));
            yade_motion_.remember(state());
            state().cell.velocity_gradient = gradient;
            expect_running(move_on());
        }
    }

    // Steps with the time stepper, the servo driving to the goals set.
    void run(long long steps, double damping) {
        nb::gil_scoped_release release;
        set_damping(state(), damping);
        for (const long long last = state().steps + steps; state().steps < last;) {
            heed_signals();
            const long long next = std::min(last, state().steps + steps_between_looks);
            if (as_yade)
                run_as_yade(next);
            else
                expect_running(owned_.advance([&] { return static_cast<Status>(best_target().run({CompiledEngines::index<Engine>(), &state(), next})); }));
        }
    }

    // Goes on along a path, from its beginning or from where the last call left it, until one more state is recorded. False where the path was at its end.
    bool follow(const std::vector<Stage>& stages, const Economy& economy, long long step_limit) {
        nb::gil_scoped_release release;
        const Rest rest = economy.rest();
        if (path_.stage == static_cast<Index>(stages.size())) return false;
        if (state().steps == 0) enter_stage(stages[0], state(), path_, rest);
        std::vector<Record> records(stages.size());
        Status status = Status::running;
        // Step by step, so that the state in hand is the one that was recorded.
        for (const Index before = path_.records; status == Status::running && path_.records == before;) {
            if (state().steps % steps_between_looks == 0) heed_signals();
            if (state().steps >= step_limit) throw std::runtime_error("the simulation reached its limit of steps");
            status = owned_.advance([&] {
                return static_cast<Status>(best_target().follow(
                    {CompiledEngines::index<Engine>(), &state(), stages.data(), static_cast<Index>(stages.size()), &path_, &rest, records.data(), 1}));
            });
        }
        if (status != Status::finished) expect_running(status);
        return true;
    }

    bool as_yade = false;

  private:
    Progress path_;
    YadeMotion<Real> yade_motion_;

    void run_as_yade(long long last_step) {
        while (state().steps < last_step) {
            expect_running(owned_.advance([&] { return find_forces(SerialTeam{}, state()); }));
            yade_motion_.remember(state());
            choose_time_step(SerialTeam{}, state());
            drive_cell(state());
            expect_running(move_on());
        }
    }
    Status move_on() { return as_yade ? yade_motion_.move(SerialTeam{}, state()) : move(SerialTeam{}, state()); }

    static constexpr long long steps_between_looks = 50;

    // Ctrl-C is Python's to notice.
    static void heed_signals() {
        nb::gil_scoped_acquire acquire;
        if (PyErr_CheckSignals()) throw nb::python_error();
    }
    static void expect_running(Status status) {
        if (status == Status::diverged) throw std::runtime_error("the simulation diverged: a particle's motion ran away");
        if (status == Status::cell_too_small) throw std::runtime_error("the periodic cell has become too small for its largest particles");
    }
};

template <class Engine> nb::dict contacts_of(InteractiveSimulation<Engine>& simulation) {
    const auto& s = simulation.state();
    const auto& slots = s.neighbours.slots;
    std::vector<RenumberedPair> touching = given_pairs(s);
    std::erase_if(touching, [&](const RenumberedPair& pair) { return !slots.touching(pair.slot); });
    std::vector<Index> first, second;
    std::vector<double> overlap;
    for (const RenumberedPair& pair : touching) first.push_back(pair.first), second.push_back(pair.second), overlap.push_back(slots.overlap[pair.slot]);
    const auto vectors = [&](auto vector) {
        return vectors_as_numpy(static_cast<Index>(touching.size()), [&](Index k) {
            const auto v = vector(touching[k].slot);
            return touching[k].reversed ? -v : v;
        });
    };
    nb::dict result;
    result["first"] = as_numpy(std::move(first), {touching.size()});
    result["second"] = as_numpy(std::move(second), {touching.size()});
    result["overlap"] = as_numpy(std::move(overlap), {touching.size()});
    result["normal"] = vectors([&](Index slot) { return slots.normal[slot]; });
    result["shear"] = vectors([&](Index slot) { return slots.shear[slot]; });
    result["bending"] = vectors([&](Index slot) { return slots.bending[slot]; });
    result["twisting"] = vectors([&](Index slot) { return slots.twisting[slot]; });
    result["force"] = vectors([&](Index slot) { return contact_force(s.law, s.particles, slots, slot); });
    return result;
}

template <class Engine> nb::dict fabric_of(InteractiveSimulation<Engine>& simulation) {
    auto& s = simulation.state();
    const auto stress = stress_tensor(SerialTeam{}, s.law, s.cell, s.particles, s.neighbours.slots);
    const auto f = fabric(SerialTeam{}, s.law, s.particles, s.neighbours, stress);
    nb::dict result;
    result["coordination_number"] = f.coordination_number;
    result["a_c"] = f.a_c;
    result["a_n"] = f.a_n;
    result["a_t"] = f.a_t;
    result["contacts"] = f.contacts;
    return result;
}

// What Python calls the class of each engine.
template <class Engine> constexpr const char* simulation_name = nullptr;
template <> constexpr const char* simulation_name<Engine<double, LinearLaw>> = "LinearSimulation";
template <> constexpr const char* simulation_name<Engine<float, LinearLaw>> = "LinearSimulation32";
template <> constexpr const char* simulation_name<Engine<double, HertzLaw>> = "HertzSimulation";
template <> constexpr const char* simulation_name<Engine<float, HertzLaw>> = "HertzSimulation32";

template <class Engine> void bind_simulation(nb::module_& module) {
    using Real = typename Engine::Real;
    using GivenLaw = typename Engine::GivenLaw;
    using Sim = InteractiveSimulation<Engine>;
    module.def(
        "Simulation",
        [](const Array2& x, const Array1& r, const Matrix& h, const GivenLaw& law, double density, const std::string& precision, const Economy& economy) {
            expect_precision<Engine>(precision);
            return Sim(x, r, h, law, density, economy);
        },
        "positions"_a, "radii"_a, "edges"_a, "law"_a, "density"_a, "precision"_a = "float64", "economy"_a = Economy{});
    nb::class_<Sim>(module, simulation_name<Engine>, "A single simulation, advanced by hand.")
        .def("copy", [](const Sim& s) { return Sim(s); })
        .def("run_prescribed", &Sim::run_prescribed, "steps"_a, "velocity_gradient"_a, "time_step"_a, "damping"_a)
        .def("run", &Sim::run, "steps"_a, "damping"_a)
        .def("follow", &Sim::follow, "stages"_a, "economy"_a, "step_limit"_a,
             "Go on along the stages until one more state is recorded; False where the path was at its end. The state in hand is then that one, or a step "
             "behind it.")
        .def("set_law",
             [](Sim& s, const GivenLaw& law) {
                 s.state().law = law.template in_precision<Real>();
                 s.state().time_stepper.look_again(s.state().steps);
             })
        .def("set_goals",
             [](Sim& s, const std::vector<AxisGoal>& goals) {
                 for (Index a = 0; a < 3; ++a) s.state().servo.axis[a] = goals.at(a);
             })
        .def(
            "set_time_stepper",
            [](Sim& s, double root, Index longest_wait) { s.state().time_stepper.root = root, s.state().time_stepper.longest_wait = longest_wait; }, "root"_a,
            "longest_wait"_a, "The root of two in the critical time step, and the most steps between two estimates of it.")
        .def_rw("as_yade", &Sim::as_yade, "Move as YADE does, to the letter: for step by step comparison alone.")
        .def("restart_strain", [](Sim& s) { s.state().cell.initial_edges = s.state().cell.edges; })
        .def("set_velocities", [](Sim& s, const Array2& u) { set_given_vectors(s.state().particles, s.state().particles.velocity, u); })
        .def("set_spins", [](Sim& s, const Array2& w) { set_given_vectors(s.state().particles, s.state().particles.spin, w); })
        .def("set_velocity_gradient", [](Sim& s, const Matrix& l) { s.state().cell.velocity_gradient = as_matrix(l); })
        .def_prop_ro("positions",
                     [](Sim& s) {
                         return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().cell.edges * s.state().particles.fractional[i]; });
                     })
        .def_prop_ro(
            "velocities", [](Sim& s) { return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().particles.velocity[i]; }); },
            "Fluctuation velocities u = v - L x, (N, 3), m/s.")
        .def_prop_ro("spins", [](Sim& s) { return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().particles.spin[i]; }); })
        .def_prop_ro("forces", [](Sim& s) { return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().particles.load[i].force; }); })
        .def_prop_ro("torques", [](Sim& s) { return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().particles.load[i].torque; }); })
        .def_prop_ro("radii",
                     [](Sim& s) {
                         const auto& p = s.state().particles;
                         std::vector<double> radii(p.count);
                         for (Index i = 0; i < p.count; ++i) radii[p.given[i]] = p.radius[i];
                         return as_numpy(std::move(radii), {static_cast<std::size_t>(p.count)});
                     })
        .def_prop_ro("edges", [](Sim& s) { return as_numpy(s.state().cell.edges); })
        .def_prop_ro("velocity_gradient", [](Sim& s) { return as_numpy(s.state().cell.velocity_gradient); })
        .def_prop_ro(
            "stress_diagonal", [](Sim& s) { return vectors_as_numpy(1, [&](Index) { return s.state().stress; }); },
            "Stress xx, yy, zz at the latest force pass, (1, 3), Pa, compression positive.")
        .def_prop_ro("stress",
                     [](Sim& s) {
                         auto& t = s.state();
                         return as_numpy(stress_tensor(SerialTeam{}, t.law, t.cell, t.particles, t.neighbours.slots));
                     })
        .def_prop_ro("unbalanced_force",
                     [](Sim& s) {
                         auto& t = s.state();
                         return unbalanced_force(SerialTeam{}, t.law, t.particles, t.neighbours.slots);
                     })
        .def_prop_ro("kinetic_energy", [](Sim& s) { return kinetic_energy(SerialTeam{}, s.state().particles); })
        .def_prop_ro("elastic_energy",
                     [](Sim& s) {
                         auto& t = s.state();
                         return elastic_energy(SerialTeam{}, t.law, t.particles, t.neighbours.slots);
                     })
        .def_prop_ro("void_ratio", [](Sim& s) { return s.state().cell.volume() / solid_volume(SerialTeam{}, s.state().particles) - 1; })
        .def_prop_ro("time_step", [](Sim& s) { return s.state().time_step; })
        .def_prop_ro("time", [](Sim& s) { return s.state().time; })
        .def_prop_ro("steps", [](Sim& s) { return s.state().steps; })
        .def_prop_ro(
            "rebuilds",
            [](Sim& s) {
                const auto& n = s.state().neighbours;
                return nb::make_tuple(n.outer_rebuilds, n.near_rebuilds, n.slots.row[s.state().particles.count], n.outer_row[s.state().particles.count]);
            },
            "Rebuilds of the outer and of the near list, near pairs, outer pairs.")
        .def_prop_ro("near_pairs",
                     [](Sim& s) {
                         std::vector<Index> ends;
                         for (const RenumberedPair& pair : given_pairs(s.state())) ends.push_back(pair.first), ends.push_back(pair.second);
                         const std::size_t count = ends.size() / 2;
                         return as_numpy(std::move(ends), {count, 2});
                     })
        .def("contacts", &contacts_of<Engine>)
        .def("fabric", &fabric_of<Engine>);
}

}  // namespace

void bind_simulations(nb::module_& module) {
    CompiledEngines::each([&]<class Engine>(Engine) { bind_simulation<Engine>(module); });
}

}  // namespace graincal
