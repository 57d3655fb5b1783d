// What Python hands over: contact laws, stages of a path, options, packings.
#include "bindings.hpp"

namespace graincal {
namespace {

// A law's parameters have the same meanings, but for the second.
template <class Law> void bind_law(nb::module_& module, const char* name, const char* second, const char* words) {
    nb::class_<Law>(module, name, words)
        .def(
            "__init__",
            [](Law* self, double modulus, double ratio, double friction, double rolling_stiffness, double rolling_strength) {
                new (self) Law{modulus, ratio, friction, rolling_stiffness, rolling_strength};
            },
            "modulus"_a, nb::arg(second), "friction"_a, "rolling_stiffness"_a, "rolling_strength"_a);
}

}  // namespace

void bind_inputs(nb::module_& module) {
    bind_law<LinearLaw<double>>(module, "LinearLaw", "stiffness_ratio",
                                "Linear springs with sliding, rolling and twisting resistance: modulus E in Pa, stiffness ratio nu, friction coefficient "
                                "tan(phi), rolling stiffness beta_m and strength eta_m.");
    bind_law<HertzLaw<double>>(module, "HertzLaw", "poisson_ratio",
                               "Hertz-Mindlin with sliding, rolling and twisting resistance: Young's modulus E of the grains in Pa, their Poisson's ratio nu, "
                               "friction coefficient tan(phi), rolling stiffness beta_m and strength eta_m.");

    nb::class_<AxisGoal>(module, "AxisGoal", "What the servo drives one axis to.")
        .def(
            "__init__",
            [](AxisGoal* self, bool stress, double target, double largest_rate, double acceleration) {
                new (self) AxisGoal{stress ? Control::stress : Control::strain, target, largest_rate, acceleration};
            },
            "stress"_a, "target"_a, "largest_rate"_a, "acceleration"_a = 0.0);

    nb::class_<Stage>(module, "Stage", "One stage of a stress path: goals of the three axes, held until the packing is at rest.")
        .def(
            "__init__",
            [](Stage* self, const std::vector<AxisGoal>& goals, bool record, bool strain_origin, bool mean_stress) {
                new (self) Stage{{goals.at(0), goals.at(1), goals.at(2)}, record, strain_origin, mean_stress};
            },
            "goals"_a, "record"_a = false, "strain_origin"_a = false, "mean_stress"_a = false);

    nb::class_<Economy>(module, "Economy", "What a run may do to take fewer steps; see graincal.models.economy.")
        .def(
            "__init__",
            [](Economy* self, double strain_ramp, bool shared_bound, double mass_exponent, double settling_damping, double inertia_factor) {
                new (self) Economy{strain_ramp, shared_bound, mass_exponent, settling_damping, inertia_factor};
            },
            nb::kw_only(), "strain_ramp"_a = Economy{}.strain_ramp, "shared_bound"_a = Economy{}.shared_bound, "mass_exponent"_a = Economy{}.mass_exponent,
            "settling_damping"_a = Economy{}.settling_damping, "inertia_factor"_a = Economy{}.inertia_factor);

    nb::class_<HeldPacking>(module, "Packing").def(nb::init<const Array2&, const Array1&, const Matrix&>(), "positions"_a, "radii"_a, "edges"_a);
}

}  // namespace graincal
