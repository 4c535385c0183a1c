// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/lsmr.h"

#include "kernels/core/check.h"

namespace vesta {

void LsmrOptions::Validate() const {
  if (max_iterations < 0) Fail(kBadArgument, "lsmr.max_iterations is {}; choose 0 or more", max_iterations);
  if (!(relative_tolerance > 0 && relative_tolerance < 1)) {
    Fail(kBadArgument, "lsmr.relative_tolerance is {}; choose a value within (0, 1)", relative_tolerance);
  }
}

}  // namespace vesta
