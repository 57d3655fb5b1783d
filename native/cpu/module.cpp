// The Python face of the native engine. Input has been checked before it comes here (src/graincal/dem).
#include "bindings.hpp"

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

    bind_inputs(module);
    bind_simulations(module);
    bind_batch(module);
    bind_benchmark(module);
}
