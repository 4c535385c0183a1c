// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/check.h"
#include "solver/internal/small/small_loop.h"
#include "solver/solve_each.h"

namespace vesta::small_internal {

void CheckSmallOptions(const LmOptions& options) {
  options.Validate();
  const auto refuse = [](const char* option) {
    Fail(kUnsupported, "{} has no effect on small problems; leave it at its default, or use SolveLm", option);
  };
  const LinearSolverKind kind = options.normal_system.linear_solver;
  if (kind != LinearSolverKind::kAuto && kind != LinearSolverKind::kDenseQr) refuse("normal_system.linear_solver");
  if (options.batch_mode != BatchMode::kExact) refuse("batch_mode");
  if (options.line_search.enabled) refuse("line_search");
  if (options.step_control.max_consecutive_nonmonotonic_steps > 0) {
    refuse("step_control.max_consecutive_nonmonotonic_steps");
  }
  if (options.check_derivatives) refuse("check_derivatives");
  if (options.profile) refuse("profile");
  if (options.normal_system.metric.group_median_floor > 0) refuse("normal_system.metric.group_median_floor");
}

Index NumProblems(Index data, int data_each, Index x, int x_each) {
  const Index count = x / x_each;
  if (x != count * x_each || data != count * data_each) {
    Fail(kBadArgument, "{} data values and {} start values; each problem needs {} and {}", data, x, data_each, x_each);
  }
  return count;
}

}  // namespace vesta::small_internal
