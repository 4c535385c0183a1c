// SPDX-License-Identifier: Apache-2.0
// The groups of the extension module. Functions that take long release the GIL.
#pragma once

#include <pybind11/pybind11.h>

namespace vesta::python {

namespace py = pybind11;

// Residual programs, and the problems that consist of them.
void AddProblem(py::module_& module);
// Problems of linear operators.
void AddOperators(py::module_& module);
// Many small problems at once.
void AddSolveEach(py::module_& module);

// Splats, scenes and trainings, and images of splats.
void AddSplats(py::module_& module);
void AddScene(py::module_& module);
void AddRasterization(py::module_& module);

}  // namespace vesta::python
