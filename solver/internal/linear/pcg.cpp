// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/pcg.h"

#include "kernels/core/check.h"

namespace vesta {

const char* ToString(PcgStatus status) {
  switch (status) {
    case PcgStatus::kConverged:
      return "converged";
    case PcgStatus::kModelConverged:
      return "model converged";
    case PcgStatus::kMaxIterations:
      return "iteration limit";
    case PcgStatus::kIndefinite:
      return "indefinite";
    case PcgStatus::kNonFinite:
      return "not finite";
  }
  return "unknown";
}

void PcgOptions::Validate() const {
  if (max_iterations < 0) Fail(kBadArgument, "pcg.max_iterations is {}; choose 0 or more", max_iterations);
  if (min_iterations < 0) Fail(kBadArgument, "pcg.min_iterations is {}; choose 0 or more", min_iterations);
  if (residual_reset_period < 0)
    Fail(kBadArgument, "pcg.residual_reset_period is {}; choose 0 or more", residual_reset_period);
  for (const double tolerance : {relative_tolerance, absolute_tolerance, model_tolerance}) {
    if (!(tolerance >= 0)) Fail(kBadArgument, "a tolerance of pcg is {}; choose 0 or more", tolerance);
  }
}

}  // namespace vesta
