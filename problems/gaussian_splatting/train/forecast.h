// What the rest of the Adam stage will be like.
#pragma once

#include <algorithm>

#include "problems/gaussian_splatting/density/growth_forecast.h"
#include "problems/gaussian_splatting/train/options.h"
#include "problems/gaussian_splatting/train/stage_pace.h"

namespace vesta::gs {

struct StageAhead {
  double seconds = 0;         // of an iteration, mean over what is left of the stage
  double full_seconds = 0;    // the same had all of them views of full size
  double change_seconds = 0;  // of all changes of the model
  double gaussians = 0;       // at its end
  double most_gaussians = 0;  // at a time

  // Iterations for which so many seconds suffice. At most three quarters of these are kept for changes: how long they
  // take is not known before some were seen, and a stage that hurries for fear of them cannot go back.
  double IterationsIn(double available) const {
    return (available - std::min(change_seconds, 0.75 * available)) / seconds;
  }
};

// done: the part of the stage that is behind, under 1, with so many Gaussians. has_coarse_views: whether there are
// views of half size. before_pruning: how many there were when pruning began, 0 where it has not. judging: iterations
// that look at as many views as judge Gaussians. Needs pace.is_known().
StageAhead ForecastStage(const StagePace& pace, const GrowthForecast& growth, const TrainOptions& options, double done,
                         Index gaussians, bool has_coarse_views, Index before_pruning = 0, double judging = 0);

}  // namespace vesta::gs
