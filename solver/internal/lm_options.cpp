// SPDX-License-Identifier: Apache-2.0
#include "solver/lm_options.h"

#include <limits>

#include "kernels/core/check.h"

namespace vesta {

const char* ToString(BatchMode mode) { return mode == BatchMode::kExact ? "exact sum of batches" : "batch merge"; }

void LmOptions::Validate() const {
  if (max_iterations < 0) Fail(kBadArgument, "max_iterations is {}; choose 0 or more", max_iterations);
  if (max_consecutive_rejects < 1)
    Fail(kBadArgument, "max_consecutive_rejects is {}; choose 1 or more", max_consecutive_rejects);
  if (!(max_seconds > 0)) Fail(kBadArgument, "max_seconds is {}; choose more than 0", max_seconds);
  const auto check = [](const char* name, double tolerance) {
    if (!(tolerance >= 0)) Fail(kBadArgument, "{} is {}; choose 0 or more", name, tolerance);
  };
  check("function_tolerance", function_tolerance);
  check("gradient_tolerance", gradient_tolerance);
  check("parameter_tolerance", parameter_tolerance);
  step_control.Validate();
  if (step_control.rule != step_rule) {
    Fail(kBadArgument,
         "step_rule is {}, while step_control has the values of {}; choose a rule by SetStepRule, then change values",
         ToString(step_rule), ToString(step_control.rule));
  }
  const double preconditioner_lambda = normal_system.preconditioner_lambda.value_or(0);
  if (!(preconditioner_lambda >= 0 && preconditioner_lambda <= std::numeric_limits<double>::max())) {
    Fail(kBadArgument, "normal_system.preconditioner_lambda is {}; choose 0 or more", preconditioner_lambda);
  }
  normal_system.pcg.Validate();
  normal_system.lsmr.Validate();
  normal_system.metric.Validate();
  line_search.Validate();
}

}  // namespace vesta
