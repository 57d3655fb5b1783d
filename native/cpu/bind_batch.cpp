// Batches of simulations, and what comes out of them.
#include <chrono>
#include <memory>
#include <new>
#include <optional>
#include <span>

#include "batch.hpp"
#include "bindings.hpp"

namespace graincal {
namespace {

// The recorded states as columns: name -> (T,).
nb::dict columns_of(std::span<const Record> records) {
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

// Threads of a batch may wait for the interpreter, to show a record: who waits for them must not hold it.
class InterpretedBatch : public Batch {
  public:
    using Batch::Batch;
    ~InterpretedBatch() {
        nb::gil_scoped_release release;
        finish();
    }
};

// Calls watch(task, columns). What it raises goes to whoever asks for the next outcome.
Batch::Watch as_watch(const nb::object& watch) {
    if (watch.is_none()) return {};
    // A thread must not count references without the interpreter, so that it holds none.
    return [handle = nb::handle(watch)](Index task, std::span<const Record> records) {
        nb::gil_scoped_acquire acquire;
        const int stops = PyObject_IsTrue(nb::object(handle(task, columns_of(records))).ptr());
        if (stops < 0) throw nb::python_error();
        return stops != 0;
    };
}

nb::object next_outcome(InterpretedBatch& batch, double patience) {
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

template <class Engine> void bind_start(nb::class_<InterpretedBatch>& batch) {
    using Real = typename Engine::Real;
    using Law = typename Engine::Law;
    batch.def(
        "__init__",
        [](InterpretedBatch* self, const std::vector<HeldPacking>& packings, const std::vector<typename Engine::GivenLaw>& laws, double density,
           const std::vector<Stage>& stages, const std::vector<Index>& order, unsigned threads, long long step_limit, const std::string& instruction_set,
           const std::string& precision, const Economy& economy, const nb::object& watch, const std::vector<Index>& packing_of) {
            expect_precision<Engine>(precision);
            auto make = [packings, packing_of, laws, density, stages, step_limit, economy](Index k) {
                const HeldPacking& packing = packings.at(packing_of.empty() ? 0 : packing_of.at(k));
                return Task<Engine>{OwnedSimulation<Real, Law>(packing, laws.at(k).template in_precision<Real>(), density, economy), stages, economy.rest(),
                                    step_limit};
            };
            const Target& target = target_named(instruction_set);
            nb::gil_scoped_release release;  // threads that are given up again may wait for it
            new (self) InterpretedBatch(std::move(make), order, threads, target, as_watch(watch));
        },
        "packings"_a, "laws"_a, "density"_a, "stages"_a, "order"_a, "threads"_a, "step_limit"_a, "instruction_set"_a = "", "precision"_a = "float64",
        "economy"_a = Economy{}, "watch"_a = nb::none(), "packing_of"_a = std::vector<Index>{}, nb::keep_alive<1, 12>(),
        "packing_of: for each law the number of its packing; all have the first where none are given.");
}

}  // namespace

void bind_batch(nb::module_& module) {
    nb::class_<InterpretedBatch> batch(module, "Batch", "Simulations along one stress path, on a pool of threads.");
    batch.def("next", &next_outcome, "patience"_a, "The next outcome in order of completion, or None if none comes within `patience` seconds.")
        .def("cancel", [](InterpretedBatch& batch) { batch.cancel(); });
    CompiledEngines::each([&]<class Engine>(Engine) { bind_start<Engine>(batch); });
}

}  // namespace graincal
