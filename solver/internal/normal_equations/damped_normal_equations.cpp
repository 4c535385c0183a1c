// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/normal_equations/damped_normal_equations.h"

#include "kernels/core/check.h"

namespace vesta {

void DampingMetricOptions::Validate() const {
  if (!(min_diagonal > 0 && min_diagonal <= max_diagonal)) {
    Fail(kBadArgument, "metric: D is clamped to [{}, {}]; need 0 < min_diagonal <= max_diagonal", min_diagonal,
         max_diagonal);
  }
  if (!(group_median_floor >= 0))
    Fail(kBadArgument, "metric.group_median_floor is {}; choose 0 or more", group_median_floor);
}

}  // namespace vesta
