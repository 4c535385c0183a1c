// SPDX-License-Identifier: Apache-2.0
#include "splatting/parsimony/judging_views.h"

#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {

JudgingViews TrainingViewsOf(const Scene& scene, const std::array<double, 3>& background,
                             const ProcessGroup& processes) {
  JudgingViews judges{.views = {}, .background = background, .near = NearPlane(scene), .processes = processes};
  for (const View& view : scene.views) {
    if (view.is_trained()) judges.views.push_back(&view);
  }
  return judges;
}

}  // namespace vesta::gs
