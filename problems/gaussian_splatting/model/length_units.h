// SPDX-License-Identifier: Apache-2.0
// The unit of length in which the position of a Gaussian is trained.
#pragma once

#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/for_each.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/depth_in_view.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

inline namespace VESTA_ISA {

// Unit of length of one Gaussian, by the same function on host and device. It is half the depth of the mean in the
// nearest of `count` views that show it beyond their near plane, or `otherwise` if none does.
VESTA_HD inline float LengthUnit(const splat::PosedCamera* views, Index count, double otherwise, const float mean[3]) {
  double nearest = 0;  // 0: none found yet
  for (Index k = 0; k < count; ++k) {
    const double depth = DepthInView(views[k].R, views[k].T, views[k], mean);
    if (depth > views[k].near && (nearest == 0 || depth < nearest)) nearest = depth;
  }
  return static_cast<float>(nearest > 0 ? 0.5 * nearest : otherwise);
}

}  // namespace VESTA_ISA

// The views used for the units: at most 64, evenly spread. near: distance of the near plane.
std::vector<splat::PosedCamera> UnitViews(const std::vector<const View*>& views, double near);

// Computes LengthUnit of Gaussian i from its mean. All pointers are in one memory space.
struct MeasureUnit {
  Index count;
  const float* x;  // [count] Gaussians (kernels/gaussian_splatting/formulas/layout.h)
  const splat::PosedCamera* views;
  Index num_views;
  double otherwise;
  float* units;

  VESTA_HD void operator()(Index i) const {
    float mean[3];
    for (int k = 0; k < 3; ++k) mean[k] = x[(splat::kMean + k) * count + i];
    units[i] = LengthUnit(views, num_views, otherwise, mean);
  }
};

// LengthUnit of each Gaussian at x. With these units a position's learning rate is a rate in pixels: it limits the
// motion in any view, near or far. (Kerbl et al. 2023 use one unit for the whole scene.) views: from UnitViews.
template <class Space>
Buffer<float, Space> MeasureUnits(Index count, const float* x, const Buffer<splat::PosedCamera, Space>& views,
                                  double otherwise) {
  Buffer<float, Space> units;
  units.ResizeForOverwrite(count);
  ForEach<Space>(count, 256, MeasureUnit{count, x, views.data(), views.size(), otherwise, units.data()});
  return units;
}

// The same for a model on the host, directly from the views.
std::vector<float> LengthUnits(const SplatModel& model, const std::vector<const View*>& views, double near,
                               double otherwise);

}  // namespace vesta::gs
