// SPDX-License-Identifier: Apache-2.0
// The unit of length of each Gaussian: half its depth in the nearest view. It multiplies the learning rate of
// positions, so that a step moves near and far Gaussians by about the same number of pixels.
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

// Unit of length of one Gaussian, in world units: half the smallest depth of its mean in those of the `count` views
// that show the mean beyond their near plane. If no view does, it is `otherwise`. Runs on host and device.
VESTA_HD inline float LengthUnit(const splat::PosedCamera* views, Index count, double otherwise, const float mean[3]) {
  double nearest = 0;  // 0: none found yet
  for (Index k = 0; k < count; ++k) {
    const double depth = DepthInView(views[k].R, views[k].T, views[k], mean);
    if (depth > views[k].near && (nearest == 0 || depth < nearest)) nearest = depth;
  }
  return static_cast<float>(nearest > 0 ? 0.5 * nearest : otherwise);
}

}  // namespace VESTA_ISA

// Takes at most 64 of `views`, evenly spread. near: distance of the near plane.
std::vector<splat::PosedCamera> LengthUnitViews(const std::vector<const View*>& views, double near);

// units[i] = LengthUnit of Gaussian i. All pointers are in one memory space.
struct MeasureUnit {
  Index count;
  const float* x;  // `count` Gaussians in the layout of kernels/gaussian_splatting/formulas/layout.h
  const splat::PosedCamera* views;
  Index num_views;
  double otherwise;  // see LengthUnit
  float* units;      // [count]

  VESTA_HD void operator()(Index i) const {
    float mean[3];
    for (int k = 0; k < 3; ++k) mean[k] = x[(splat::kMean + k) * count + i];
    units[i] = LengthUnit(views, num_views, otherwise, mean);
  }
};

// LengthUnit of each of the `count` Gaussians at x. views: from LengthUnitViews.
template <class Space>
Buffer<float, Space> MeasureUnits(Index count, const float* x, const Buffer<splat::PosedCamera, Space>& views,
                                  double otherwise) {
  Buffer<float, Space> units;
  units.ResizeForOverwrite(count);
  ForEach<Space>(count, 256, MeasureUnit{count, x, views.data(), views.size(), otherwise, units.data()});
  return units;
}

// The same on the host; `views` are all training views.
std::vector<float> LengthUnits(const SplatModel& model, const std::vector<const View*>& views, double near,
                               double otherwise);

}  // namespace vesta::gs
