// SPDX-License-Identifier: Apache-2.0
// In what unit of length one Gaussian's position is trained: host and device call the same function.
#pragma once

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "problems/gaussian_splatting/scene/depth_in_view.h"

namespace vesta::gs {
inline namespace VESTA_ISA {

// Half the depth of the mean in the nearest of `count` views that hold it beyond their near planes, or `otherwise`.
VESTA_HD inline float LengthUnit(const splat::PosedCamera* views, Index count, double otherwise, const float mean[3]) {
  double nearest = 0;  // none so far
  for (Index k = 0; k < count; ++k) {
    const double depth = DepthInView(views[k].R, views[k].T, views[k], mean);
    if (depth > views[k].near && (nearest == 0 || depth < nearest)) nearest = depth;
  }
  return static_cast<float>(nearest > 0 ? 0.5 * nearest : otherwise);
}

}  // namespace VESTA_ISA
}  // namespace vesta::gs
