// Where a run's time goes and what the machine could do, for benchmarks/engine.py.
#include <algorithm>
#include <ctime>

#include "bindings.hpp"

namespace graincal {
namespace {

// Of the processor: what else a machine does then counts by its caches alone.
double seconds_now() { return double(std::clock()) / CLOCKS_PER_SEC; }

// A whole path, each pass of its steps timed.
template <class Engine> void bind_passes(nb::module_& module) {
    using Real = typename Engine::Real;
    module.def(
        "time_passes",
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
                    const PathCall call{
                        CompiledEngines::index<Engine>(), &owned.state, stages.data(), static_cast<Index>(stages.size()), &progress, &rest, records.data(), 50};
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
    module.def(
        "arithmetic_rate",
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
    module.def(
        "triad_rate",
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

}  // namespace

void bind_benchmark(nb::module_& module) {
    CompiledEngines::each([&]<class Engine>(Engine) { bind_passes<Engine>(module); });
    bind_machine(module);
}

}  // namespace graincal
