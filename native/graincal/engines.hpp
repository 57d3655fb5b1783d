// The engines that are compiled: each a contact law in a precision. Whoever calls one says which by its place in this list.
#pragma once

#include "hertz_law.hpp"
#include "linear_law.hpp"
#include "stress_path.hpp"

namespace graincal {

template <class RealType, template <class> class LawType> struct Engine {
    using Real = RealType;
    using Law = LawType<Real>;
    using GivenLaw = LawType<double>;  // as it is handed over
    using State = Simulation<Real, Law>;
};

template <class A, class B> constexpr bool same = false;
template <class A> constexpr bool same<A, A> = true;

template <class... Engines> struct EngineList {
    // f(engine) for each.
    template <class F> static void each(F f) { (f(Engines{}), ...); }

    template <class Wanted> static constexpr Index index() {
        Index found = 0, at = 0;
        ((same<Wanted, Engines> ? found = at : 0, ++at), ...);
        static_assert((same<Wanted, Engines> || ...), "this engine is not among those compiled");
        return found;
    }

    // f(engine) for the one at this place.
    template <class F> static auto visit(Index place, F f) {
        Index at = 0;
        decltype(f(first(Engines{}...))) result{};
        ((at++ == place ? (result = f(Engines{}), 0) : 0), ...);
        return result;
    }

  private:
    template <class First, class... Rest> static First first(First, Rest...);
};

using CompiledEngines = EngineList<Engine<double, LinearLaw>, Engine<float, LinearLaw>, Engine<double, HertzLaw>, Engine<float, HertzLaw>>;

}  // namespace graincal
