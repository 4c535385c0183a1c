// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/settings/resolved_plan.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/initialize.h"

namespace vesta::gs {

double IterationsFor(Index training_views) {
  constexpr double kLeast = 4000, kEpochs = 76;
  return std::max(kLeast, kEpochs * static_cast<double>(training_views));
}

TrainOptions FitToScene(TrainOptions options, Index training_views) {
  ValidateOptions(options);
  AdamOptions& adam = options.adam;
  constexpr double kMost = 1e7;
  if (!adam.iterations) {
    const double all = options.time_limit > 0 ? kMost : std::round(IterationsFor(training_views) * adam.length);
    adam.iterations = static_cast<int>(std::clamp(all, 1.0, kMost));
  }
  if (adam.runs() && adam.views_per_iteration > std::max<Index>(training_views, 1)) {
    Fail(kBadArgument, "adam.views_per_iteration={}: the scene has {} training views; give it no more than these",
         adam.views_per_iteration, training_views);
  }
  if (!options.sh_degree) options.sh_degree = DefaultShDegree(training_views);
  return options;
}

}  // namespace vesta::gs
