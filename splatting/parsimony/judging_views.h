// Views to judge a model by.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/distributed/process_group.h"

namespace vesta::gs {

// The views that speak for or against a Gaussian: those that are trained on, with their images, never the test views.
struct JudgingViews {
  std::vector<const View*> views;  // must outlive this
  std::array<double, 3> background{0, 0, 0};
  double near = 0;              // distance of the near plane, world units
  ProcessGroup processes = {};  // each asks its share of the views
};

// The training views of the scene.
JudgingViews TrainingViewsOf(const Scene& scene, const std::array<double, 3>& background,
                             const ProcessGroup& processes = {});

}  // namespace vesta::gs
