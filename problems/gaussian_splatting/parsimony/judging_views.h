// Views to judge a model by.
#pragma once

#include <array>
#include <vector>

#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

// The views that speak for or against a Gaussian: those that are trained on, with their images, never the test views.
struct JudgingViews {
  std::vector<const View*> views;  // must outlive this
  std::array<double, 3> background{0, 0, 0};
  double near = 0;  // distance of the near plane, world units
  // Processes that ask the judges together, each its own (model/view_owners.h); null: this one asks all.
  Ranks* ranks = nullptr;
};

// The training views of the scene.
JudgingViews TrainingViewsOf(const Scene& scene, const std::array<double, 3>& background, Ranks* ranks = nullptr);

}  // namespace vesta::gs
