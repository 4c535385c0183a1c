// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "problems/program/batch.h"

namespace vesta::python {

// Adds the methods solve, evaluate, covariance and check.
void AddSolve(pybind11::class_<program::BatchProblem>& problem);

}  // namespace vesta::python
