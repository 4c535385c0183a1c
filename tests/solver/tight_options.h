// SPDX-License-Identifier: Apache-2.0
// Options with which a solve continues until rounding ends it.
#pragma once

#include "solver/levenberg_marquardt.h"

namespace vesta {

inline LmOptions Tight() {
  LmOptions options;
  options.max_iterations = 200;
  options.function_tolerance = 0;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-15;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  options.normal_system.pcg = {.max_iterations = 100, .relative_tolerance = 1e-14, .model_tolerance = 0};
  return options;
}

}  // namespace vesta
