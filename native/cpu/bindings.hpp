// What the parts of the Python face share: arrays, packings, and the names that Python has for precisions, outcomes and instruction sets.
#pragma once

#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "graincal/economy.hpp"
#include "graincal/engines.hpp"
#include "owned_simulation.hpp"
#include "targets.hpp"

namespace graincal {

namespace nb = nanobind;
using namespace nb::literals;

using Array1 = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Array2 = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Matrix = nb::ndarray<const double, nb::shape<3, 3>, nb::c_contig, nb::device::cpu>;

template <class T> nb::object as_numpy(std::vector<T> values, std::initializer_list<std::size_t> shape) {
    auto* held = new std::vector<T>(std::move(values));
    nb::capsule owner(held, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, T>(held->data(), shape, owner), nb::rv_policy::move);
}
inline Mat3<double> as_matrix(const Matrix& m) {
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

// A packing held for as long as simulations are made from it.
struct HeldPacking {
    std::vector<double> positions, radii;
    Mat3<double> edges;

    HeldPacking(const Array2& x, const Array1& r, const Matrix& h)
        : positions(x.data(), x.data() + x.size()), radii(r.data(), r.data() + r.size()), edges(as_matrix(h)) {}
    operator PackingView() const { return {positions, radii, edges}; }
};

inline const char* name_of(Status status) {
    switch (status) {
        case Status::running:
            return "running";
        case Status::finished:
            return "finished";
        case Status::cell_too_small:
            return "cell_too_small";
        case Status::diverged:
            return "diverged";
        case Status::out_of_steps:
            return "out_of_steps";
        case Status::out_of_memory:
            return "out_of_memory";
        case Status::stopped:
            return "stopped";
        default:
            return "cancelled";
    }
}

// The target of that name, or the best for none.
inline const Target& target_named(const std::string& name) {
    if (name.empty()) return best_target();
    for (const Target* target = targets; target->name; ++target)
        if (name == target->name && target->runs_here()) return *target;
    throw std::invalid_argument("no instruction set " + name + " on this machine");
}

// What Python calls precisions.
template <class Real> constexpr const char* precision_name = nullptr;
template <> constexpr const char* precision_name<double> = "float64";
template <> constexpr const char* precision_name<float> = "float32";

// The engine is chosen by the type of the law and by the name of the precision: the first that both fit is taken.
template <class Engine> void expect_precision(const std::string& name) {
    if (name != precision_name<typename Engine::Real>) throw nb::next_overload();
}

// Each binds its part of the module; what the others take as arguments comes first.
void bind_inputs(nb::module_& module);
void bind_simulations(nb::module_& module);
void bind_batch(nb::module_& module);
void bind_benchmark(nb::module_& module);

}  // namespace graincal
