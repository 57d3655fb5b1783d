// The Python face of the native engine. Input has been checked before it comes here (src/graincal/dem).
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "batch.hpp"
#include "benchmark.hpp"
#include "yade_comparison.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace graincal {
namespace {

using Array1 = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Array2 = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Matrix = nb::ndarray<const double, nb::shape<3, 3>, nb::c_contig, nb::device::cpu>;

template <class T> nb::object as_numpy(std::vector<T> values, std::initializer_list<std::size_t> shape) {
    auto* held = new std::vector<T>(std::move(values));
    nb::capsule owner(held, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, T>(held->data(), shape, owner), nb::rv_policy::move);
}
Mat3<double> as_matrix(const Matrix& m) {
    Mat3<double> result;
    for (Index i = 0; i < 3; ++i)
        for (Index j = 0; j < 3; ++j) result(i, j) = m(i, j);
    return result;
}
template <class Real> nb::object as_numpy(const Mat3<Real>& m) {
    std::vector<double> values;
    for (Index i = 0; i < 3; ++i)
        for (Index j = 0; j < 3; ++j) values.push_back(m(i, j));
    return as_numpy(std::move(values), {3, 3});
}
template <class F> nb::object vectors_as_numpy(Index count, F vector) {
    std::vector<double> values(3 * static_cast<std::size_t>(count));
    for (Index i = 0; i < count; ++i) {
        const auto v = vector(i);
        values[3 * i] = v.x, values[3 * i + 1] = v.y, values[3 * i + 2] = v.z;
    }
    return as_numpy(std::move(values), {static_cast<std::size_t>(count), 3});
}

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

// A near pair by its particles as given, the lower first; reversed where the engine has it the other way round.
struct GivenPair {
    Index first, second, slot;
    bool reversed;
};
template <class Sim> std::vector<GivenPair> given_pairs(const Sim& sim) {
    const auto& slots = sim.neighbours.slots;
    std::vector<GivenPair> pairs;
    for (Index slot = 0; slot < slots.row[sim.particles.count]; ++slot) {
        const Index i = sim.particles.given[slots.first[slot]], j = sim.particles.given[slots.second[slot]];
        pairs.push_back({std::min(i, j), std::max(i, j), slot, i > j});
    }
    std::sort(pairs.begin(), pairs.end(), [](const GivenPair& a, const GivenPair& b) { return std::pair(a.first, a.second) < std::pair(b.first, b.second); });
    return pairs;
}

// A packing held for as long as simulations are made from it.
struct HeldPacking {
    std::vector<double> positions, radii;
    Mat3<double> edges;

    HeldPacking(const Array2& x, const Array1& r, const Matrix& h)
        : positions(x.data(), x.data() + x.size()), radii(r.data(), r.data() + r.size()), edges(as_matrix(h)) {}
    operator PackingView() const { return {positions, radii, edges}; }
};

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

    bool as_yade = false;

  private:
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
    std::vector<GivenPair> touching = given_pairs(s);
    std::erase_if(touching, [&](const GivenPair& pair) { return !slots.touching(pair.slot); });
    std::vector<Index> first, second;
    std::vector<double> overlap;
    for (const GivenPair& pair : touching) first.push_back(pair.first), second.push_back(pair.second), overlap.push_back(slots.overlap[pair.slot]);
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

const char* name_of(Status status) {
    switch (status) {
        case Status::running: return "running";
        case Status::finished: return "finished";
        case Status::cell_too_small: return "cell_too_small";
        case Status::diverged: return "diverged";
        case Status::out_of_steps: return "out_of_steps";
        case Status::out_of_memory: return "out_of_memory";
        default: return "cancelled";
    }
}

// The recorded states as columns: name -> (T,).
nb::dict columns_of(const std::vector<Record>& records) {
    nb::dict result;
    const auto column = [&](const char* name, auto value) {
        std::vector<double> values;
        for (const auto& record : records) values.push_back(static_cast<double>(value(record)));
        result[name] = as_numpy(std::move(values), {records.size()});
    };
    column("volume", [](const auto& r) { return determinant(r.edges); });
    column("strain_x", [](const auto& r) { return r.strain.x; });
    column("strain_y", [](const auto& r) { return r.strain.y; });
    column("strain_z", [](const auto& r) { return r.strain.z; });
    column("stress_xx", [](const auto& r) { return r.stress(0, 0); });
    column("stress_yy", [](const auto& r) { return r.stress(1, 1); });
    column("stress_zz", [](const auto& r) { return r.stress(2, 2); });
    column("coordination_number", [](const auto& r) { return r.fabric.coordination_number; });
    column("a_c", [](const auto& r) { return r.fabric.a_c; });
    column("a_n", [](const auto& r) { return r.fabric.a_n; });
    column("a_t", [](const auto& r) { return r.fabric.a_t; });
    column("contacts", [](const auto& r) { return r.fabric.contacts; });
    column("unbalanced_force", [](const auto& r) { return r.unbalanced_force; });
    column("steps", [](const auto& r) { return r.steps; });
    column("flagged", [](const auto& r) { return r.flagged; });
    return result;
}

double seconds_now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// The target of that name, or the best for none.
const Target& target_named(const std::string& name) {
    if (name.empty()) return best_target();
    for (const Target* target = targets; target->name; ++target)
        if (name == target->name && target->runs_here()) return *target;
    throw std::invalid_argument("no instruction set " + name + " on this machine");
}

nb::object next_outcome(Batch& batch, double patience) {
    std::optional<Outcome> outcome;
    {
        nb::gil_scoped_release release;
        outcome = batch.next(std::chrono::duration<double>(patience));
    }
    if (!outcome) return nb::none();
    nb::dict result;
    result["task"] = outcome->task;
    result["status"] = name_of(outcome->status);
    result["columns"] = columns_of(outcome->records);
    result["consolidation_flagged"] = outcome->consolidation_flagged;
    result["steps"] = outcome->steps;
    result["seconds"] = outcome->seconds;
    return result;
}

// What Python calls precisions, and the classes of simulations.
template <class Real> constexpr const char* precision_name = nullptr;
template <> constexpr const char* precision_name<double> = "float64";
template <> constexpr const char* precision_name<float> = "float32";
template <class Engine> constexpr const char* simulation_name = nullptr;
template <> constexpr const char* simulation_name<Engine<double, LinearLaw>> = "LinearSimulation";
template <> constexpr const char* simulation_name<Engine<float, LinearLaw>> = "LinearSimulation32";
template <> constexpr const char* simulation_name<Engine<double, HertzLaw>> = "HertzSimulation";
template <> constexpr const char* simulation_name<Engine<float, HertzLaw>> = "HertzSimulation32";

template <class Law> void bind_law(nb::module_& module, const char* name, const char* second, const char* words);
template <class Engine> void bind_start(nb::class_<Batch>& batch);
template <class Engine> void bind_benchmark(nb::module_& module);
void bind_machine(nb::module_& module);
template <class Engine> void bind_simulation(nb::module_& module);

}  // namespace
}  // namespace graincal

NB_MODULE(_native, module) {
    using namespace graincal;
    module.doc() = "graincal's native Discrete Element Method engine";
    module.attr("commit") = GRAINCAL_COMMIT;
    module.attr("compiler") = GRAINCAL_COMPILER;
    module.attr("instruction_set") = best_target().name;
    nb::list runnable;
    for (const Target* target = targets; target->name; ++target)
        if (target->runs_here()) runnable.append(target->name);
    module.attr("instruction_sets") = runnable;

    bind_law<LinearLaw<double>>(module, "LinearLaw", "stiffness_ratio",
                                "Linear springs with sliding, rolling and twisting resistance: modulus E in Pa, stiffness ratio nu, friction coefficient "
                                "tan(phi), rolling stiffness beta_m and strength eta_m.");
    bind_law<HertzLaw<double>>(module, "HertzLaw", "poisson_ratio",
                               "Hertz-Mindlin with sliding, rolling and twisting resistance: Young's modulus E of the grains in Pa, their Poisson's ratio nu, "
                               "friction coefficient tan(phi), rolling stiffness beta_m and strength eta_m.");

    nb::class_<AxisGoal>(module, "AxisGoal", "What the servo drives one axis to.")
        .def("__init__",
             [](AxisGoal* self, bool stress, double target, double largest_rate, double acceleration) {
                 new (self) AxisGoal{stress ? Control::stress : Control::strain, target, largest_rate, acceleration};
             },
             "stress"_a, "target"_a, "largest_rate"_a, "acceleration"_a = 0.0);

    nb::class_<Stage>(module, "Stage", "One stage of a stress path: goals of the three axes, held until the packing is at rest.")
        .def("__init__",
             [](Stage* self, const std::vector<AxisGoal>& goals, bool record, bool strain_origin, bool mean_stress) {
                 new (self) Stage{{goals.at(0), goals.at(1), goals.at(2)}, record, strain_origin, mean_stress};
             },
             "goals"_a, "record"_a = false, "strain_origin"_a = false, "mean_stress"_a = false);

    nb::class_<Economy>(module, "Economy", "What a run may do to take fewer steps; see graincal.models.economy.")
        .def("__init__",
             [](Economy* self, double strain_ramp, bool shared_bound, double mass_exponent, double settling_damping, double inertia_factor) {
                 new (self) Economy{strain_ramp, shared_bound, mass_exponent, settling_damping, inertia_factor};
             },
             nb::kw_only(), "strain_ramp"_a = Economy{}.strain_ramp, "shared_bound"_a = Economy{}.shared_bound,
             "mass_exponent"_a = Economy{}.mass_exponent, "settling_damping"_a = Economy{}.settling_damping, "inertia_factor"_a = Economy{}.inertia_factor);

    nb::class_<HeldPacking>(module, "Packing").def(nb::init<const Array2&, const Array1&, const Matrix&>(), "positions"_a, "radii"_a, "edges"_a);

    nb::class_<Batch> batch(module, "Batch", "Simulations of one packing along one stress path, on a pool of threads.");
    batch.def("next", &next_outcome, "patience"_a, "The next outcome in order of completion, or None if none comes within `patience` seconds.")
        .def("cancel", &Batch::cancel);
    CompiledEngines::each([&]<class Engine>(Engine) {
        bind_simulation<Engine>(module);
        bind_start<Engine>(batch);
        bind_benchmark<Engine>(module);
    });
    bind_machine(module);
}

namespace graincal {
namespace {

// A law's parameters have the same meanings, but for the second.
template <class Law> void bind_law(nb::module_& module, const char* name, const char* second, const char* words) {
    nb::class_<Law>(module, name, words)
        .def("__init__",
             [](Law* self, double modulus, double ratio, double friction, double rolling_stiffness, double rolling_strength) {
                 new (self) Law{modulus, ratio, friction, rolling_stiffness, rolling_strength};
             },
             "modulus"_a, nb::arg(second), "friction"_a, "rolling_stiffness"_a, "rolling_strength"_a);
}

// The engine is chosen by the type of the law and by the name of the precision: the first that both fit is taken.
template <class Engine> void expect_precision(const std::string& name) {
    if (name != precision_name<typename Engine::Real>) throw nb::next_overload();
}

template <class Engine> void bind_start(nb::class_<Batch>& batch) {
    using Real = typename Engine::Real;
    using Law = typename Engine::Law;
    batch.def("__init__",
             [](Batch* self, const HeldPacking& packing, const std::vector<typename Engine::GivenLaw>& laws, double density, const std::vector<Stage>& stages,
                const std::vector<Index>& order, unsigned threads, long long step_limit, const std::string& instruction_set, const std::string& precision,
                const Economy& economy) {
                 expect_precision<Engine>(precision);
                 auto held = std::make_shared<const HeldPacking>(packing);
                 const auto make = [held, laws, density, stages, step_limit, economy](Index k) {
                     return Task<Engine>{OwnedSimulation<Real, Law>(*held, laws[k].template in_precision<Real>(), density, economy), stages, economy.rest(), step_limit};
                 };
                 new (self) Batch(make, order, threads, target_named(instruction_set));
             },
             "packing"_a, "laws"_a, "density"_a, "stages"_a, "order"_a, "threads"_a, "step_limit"_a, "instruction_set"_a = "", "precision"_a = "float64",
             "economy"_a = Economy{});
}

// A whole path, each pass of its steps timed.
template <class Engine> void bind_benchmark(nb::module_& module) {
    using Real = typename Engine::Real;
    module.def("time_passes",
               [](const HeldPacking& packing, const typename Engine::GivenLaw& law, double density, const std::vector<Stage>& stages,
                  const std::string& instruction_set, const std::string& precision) {
                   expect_precision<Engine>(precision);
                   OwnedSimulation<Real, typename Engine::Law> owned(packing, law.template in_precision<Real>(), density);
                   const Target& target = target_named(instruction_set);
                   const std::vector<const char*> names{"outer list", "near list", "forces", "stiffness", "stage", "motion"};  // as Pass has them
                   std::vector<double> seconds(names.size());
                   std::vector<Record> records(stages.size());
                   const Rest rest;
                   Progress progress;
                   enter_stage(stages[0], owned.state, progress, rest);
                   Status status = Status::running;
                   while (status == Status::running) {
                       if (PyErr_CheckSignals()) throw nb::python_error();
                       nb::gil_scoped_release release;
                       status = owned.advance([&] {
                           const PathCall call{CompiledEngines::index<Engine>(), &owned.state, stages.data(), static_cast<Index>(stages.size()),
                                               &progress, &rest, records.data(), 50};
                           return static_cast<Status>(target.benchmark.follow_timed(call, &seconds_now, seconds.data()));
                       });
                   }
                   if (status != Status::finished) throw std::runtime_error(name_of(status));
                   const auto& s = owned.state;
                   nb::dict by_pass, result;
                   for (std::size_t pass = 0; pass < names.size(); ++pass) by_pass[names[pass]] = seconds[pass];
                   result["seconds"] = by_pass;
                   result["steps"] = s.steps;
                   result["outer_rebuilds"] = s.neighbours.outer_rebuilds;
                   result["near_rebuilds"] = s.neighbours.near_rebuilds;
                   result["near_pairs"] = s.neighbours.slots.row[s.particles.count];
                   return result;
               },
               "packing"_a, "law"_a, "density"_a, "stages"_a, "instruction_set"_a = "", "precision"_a = "float64",
               "Follow a path and return the seconds spent in each pass of its steps, and how often the neighbour lists were made.");
}

// What the machine can do, measured.
void bind_machine(nb::module_& module) {
    module.def("arithmetic_rate",
               [](const std::string& precision, const std::string& instruction_set) {
                   const auto& calls = target_named(instruction_set).benchmark;
                   const auto loop = precision == "float32" ? calls.multiply_and_add_float32 : calls.multiply_and_add_float64;
                   nb::gil_scoped_release release;
                   double best = 0;
                   for (int trial = 0; trial < 5; ++trial) {
                       const double start = seconds_now(), operations = loop(5'000'000);
                       best = std::max(best, operations / (seconds_now() - start));
                   }
                   return best;
               },
               "precision"_a, "instruction_set"_a = "", "Independent multiplications and additions a second, in one thread: the best of five.");
    module.def("triad_rate",
               [](long long bytes, const std::string& instruction_set) {
                   const auto& calls = target_named(instruction_set).benchmark;
                   nb::gil_scoped_release release;
                   const long long count = std::max(bytes / (3 * (long long)sizeof(double)), 1LL), turns = std::max(200'000'000 / bytes, 1LL);
                   std::vector<double> a(count), b(count, 1.0), c(count, 2.0);
                   double best = 0;
                   for (int trial = 0; trial < 5; ++trial) {
                       const double start = seconds_now();
                       for (long long turn = 0; turn < turns; ++turn) calls.triad(a.data(), b.data(), c.data(), count);
                       best = std::max(best, 3.0 * sizeof(double) * double(count * turns) / (seconds_now() - start));
                   }
                   return best;
               },
               "bytes"_a, "instruction_set"_a = "", "Bytes a second of STREAM's triad over arrays of so many bytes together, in one thread: the best of five.");
}

template <class Engine> void bind_simulation(nb::module_& module) {
    using Real = typename Engine::Real;
    using GivenLaw = typename Engine::GivenLaw;
    using Sim = InteractiveSimulation<Engine>;
    module.def("Simulation",
               [](const Array2& x, const Array1& r, const Matrix& h, const GivenLaw& law, double density, const std::string& precision, const Economy& economy) {
                   expect_precision<Engine>(precision);
                   return Sim(x, r, h, law, density, economy);
               },
               "positions"_a, "radii"_a, "edges"_a, "law"_a, "density"_a, "precision"_a = "float64", "economy"_a = Economy{});
    nb::class_<Sim>(module, simulation_name<Engine>, "A single simulation, advanced by hand.")
        .def("copy", [](const Sim& s) { return Sim(s); })
        .def("run_prescribed", &Sim::run_prescribed, "steps"_a, "velocity_gradient"_a, "time_step"_a, "damping"_a)
        .def("run", &Sim::run, "steps"_a, "damping"_a)
        .def("set_law", [](Sim& s, const GivenLaw& law) {
            s.state().law = law.template in_precision<Real>();
            s.state().time_stepper.look_again(s.state().steps);
        })
        .def("set_goals", [](Sim& s, const std::vector<AxisGoal>& goals) {
            for (Index a = 0; a < 3; ++a) s.state().servo.axis[a] = goals.at(a);
        })
        .def("set_time_stepper", [](Sim& s, double root, Index longest_wait) { s.state().time_stepper.root = root, s.state().time_stepper.longest_wait = longest_wait; },
             "root"_a, "longest_wait"_a, "The root of two in the critical time step, and the most steps between two estimates of it.")
        .def_rw("as_yade", &Sim::as_yade, "Move as YADE does, to the letter: for step by step comparison alone.")
        .def("restart_strain", [](Sim& s) { s.state().cell.initial_edges = s.state().cell.edges; })
        .def("set_velocities", [](Sim& s, const Array2& u) { set_given_vectors(s.state().particles, s.state().particles.velocity, u); })
        .def("set_spins", [](Sim& s, const Array2& w) { set_given_vectors(s.state().particles, s.state().particles.spin, w); })
        .def("set_velocity_gradient", [](Sim& s, const Matrix& l) { s.state().cell.velocity_gradient = as_matrix(l); })
        .def_prop_ro("positions", [](Sim& s) {
            return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().cell.edges * s.state().particles.fractional[i]; });
        })
        .def_prop_ro("velocities", [](Sim& s) { return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().particles.velocity[i]; }); },
                     "Fluctuation velocities u = v - L x, (N, 3), m/s.")
        .def_prop_ro("spins", [](Sim& s) { return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().particles.spin[i]; }); })
        .def_prop_ro("forces", [](Sim& s) { return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().particles.load[i].force; }); })
        .def_prop_ro("torques", [](Sim& s) { return given_vectors_as_numpy(s.state().particles, [&](Index i) { return s.state().particles.load[i].torque; }); })
        .def_prop_ro("radii", [](Sim& s) {
            const auto& p = s.state().particles;
            std::vector<double> radii(p.count);
            for (Index i = 0; i < p.count; ++i) radii[p.given[i]] = p.radius[i];
            return as_numpy(std::move(radii), {static_cast<std::size_t>(p.count)});
        })
        .def_prop_ro("edges", [](Sim& s) { return as_numpy(s.state().cell.edges); })
        .def_prop_ro("velocity_gradient", [](Sim& s) { return as_numpy(s.state().cell.velocity_gradient); })
        .def_prop_ro("stress_diagonal", [](Sim& s) { return vectors_as_numpy(1, [&](Index) { return s.state().stress; }); },
                     "Stress xx, yy, zz at the latest force pass, (1, 3), Pa, compression positive.")
        .def_prop_ro("stress", [](Sim& s) {
            auto& t = s.state();
            return as_numpy(stress_tensor(SerialTeam{}, t.law, t.cell, t.particles, t.neighbours.slots));
        })
        .def_prop_ro("unbalanced_force", [](Sim& s) {
            auto& t = s.state();
            return unbalanced_force(SerialTeam{}, t.law, t.particles, t.neighbours.slots);
        })
        .def_prop_ro("kinetic_energy", [](Sim& s) { return kinetic_energy(SerialTeam{}, s.state().particles); })
        .def_prop_ro("elastic_energy", [](Sim& s) {
            auto& t = s.state();
            return elastic_energy(SerialTeam{}, t.law, t.particles, t.neighbours.slots);
        })
        .def_prop_ro("void_ratio", [](Sim& s) { return s.state().cell.volume() / solid_volume(SerialTeam{}, s.state().particles) - 1; })
        .def_prop_ro("time_step", [](Sim& s) { return s.state().time_step; })
        .def_prop_ro("time", [](Sim& s) { return s.state().time; })
        .def_prop_ro("steps", [](Sim& s) { return s.state().steps; })
        .def_prop_ro("rebuilds", [](Sim& s) {
            const auto& n = s.state().neighbours;
            return nb::make_tuple(n.outer_rebuilds, n.near_rebuilds, n.slots.row[s.state().particles.count], n.outer_row[s.state().particles.count]);
        }, "Rebuilds of the outer and of the near list, near pairs, outer pairs.")
        .def_prop_ro("near_pairs", [](Sim& s) {
            std::vector<Index> ends;
            for (const GivenPair& pair : given_pairs(s.state())) ends.push_back(pair.first), ends.push_back(pair.second);
            const std::size_t count = ends.size() / 2;
            return as_numpy(std::move(ends), {count, 2});
        })
        .def("contacts", &contacts_of<Engine>)
        .def("fabric", &fabric_of<Engine>);
}

}  // namespace
}  // namespace graincal
