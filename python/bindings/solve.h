// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "problems/program/batch.h"
#include "solver/lm_options.h"

namespace vesta::python {

// Options of a solve by their Python names. Throws Error for unknown names and values out of range.
LmOptions ToOptions(const pybind11::dict& settings);
// A status as Python names it, such as "function_tolerance".
std::string NameOf(LmStatus status);

// Checks for Ctrl-C after each iteration, and then calls `callback` (None, or a function of a row of the history),
// which stops the solve by returning False.
LmCallback MakeCallback(const pybind11::object& callback);
pybind11::dict ToDict(const LmSummary& summary);

// Adds the methods solve, evaluate, covariance and check.
void AddSolve(pybind11::class_<program::BatchProblem>& problem);

}  // namespace vesta::python
