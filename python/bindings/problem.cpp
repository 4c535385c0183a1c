// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/bindings.h"

namespace vesta::python {

void AddProblem(py::module_& module) { module.attr("ambient") = 0; }

}  // namespace vesta::python
