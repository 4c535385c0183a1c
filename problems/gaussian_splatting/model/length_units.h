// SPDX-License-Identifier: Apache-2.0
// In what unit of length a Gaussian's position is trained.
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

// The unit for one Gaussian, by a function that host and device call: half the depth of the mean in the nearest of
// `count` views that hold it beyond their near planes, or `otherwise`.
VESTA_HD inline float LengthUnit(const splat::PosedCamera* views, Index count, double otherwise, const float mean[3]) {
  double nearest = 0;  // none so far
  for (Index k = 0; k < count; ++k) {
    const double depth = DepthInView(views[k].R, views[k].T, views[k], mean);
    if (depth > views[k].near && (nearest == 0 || depth < nearest)) nearest = depth;
  }
  return static_cast<float>(nearest > 0 ? 0.5 * nearest : otherwise);
}

}  // namespace VESTA_ISA

// The views that are looked at for it: of many only 64, evenly spread. near: distance of the near plane.
std::vector<splat::PosedCamera> UnitViews(const std::vector<const View*>& views, double near);

// LengthUnit of Gaussian i by its mean; all pointers to one memory space.
struct MeasureUnit {
  Index count;
  const float* x;  // of `count` Gaussians (kernels/gaussian_splatting/formulas/layout.h)
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

// For each Gaussian half its depth in the nearest of the views that hold its mean beyond their near plane, or
// `otherwise` where none does: a learning rate for positions is then one in pixels, at most so many in any view, near
// and far alike. (Kerbl et al. 2023 have one unit for the scene.) views: UnitViews; x: of `count` Gaussians.
template <class Space>
Buffer<float, Space> MeasureUnits(Index count, const float* x, const Buffer<splat::PosedCamera, Space>& views,
                                  double otherwise) {
  Buffer<float, Space> units;
  units.ResizeForOverwrite(count);
  ForEach<Space>(count, 256, MeasureUnit{count, x, views.data(), views.size(), otherwise, units.data()});
  return units;
}

// The same of a model on the host, by the views themselves.
std::vector<float> LengthUnits(const SplatModel& model, const std::vector<const View*>& views, double near,
                               double otherwise);

}  // namespace vesta::gs
