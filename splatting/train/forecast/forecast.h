// What the rest of the Adam stage will be like.
#pragma once

#include <algorithm>

#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/train/forecast/growth_forecast.h"
#include "splatting/train/forecast/stage_pace.h"
#include "splatting/train/settings/options.h"

namespace vesta::gs {

// How far the stage is.
struct StageProgress {
  int iteration = 0;     // done
  StageSpan span{0, 0};  // of that one
  Index gaussians = 0;
  Index before_pruning = 0;      // Gaussians that there were before some were taken out; 0: none yet
  bool has_coarse_views = true;  // of half size
};

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

// judging: iterations that look at as many views as judge Gaussians. Needs pace.is_known(), and now before the end.
StageAhead ForecastStage(const StagePace& pace, const GrowthForecast& growth, const TrainOptions& options,
                         const StageProgress& now, double judging = 0);

}  // namespace vesta::gs
