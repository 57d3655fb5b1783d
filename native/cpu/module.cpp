// The Python face of the native engine.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

NB_MODULE(_native, module) {
    module.doc() = "graincal's native Discrete Element Method engine";
    module.attr("commit") = GRAINCAL_COMMIT;
    module.attr("compiler") = GRAINCAL_COMPILER;
    module.attr("instruction_set") = GRAINCAL_INSTRUCTION_SET;
}
