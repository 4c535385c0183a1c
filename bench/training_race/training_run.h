// SPDX-License-Identifier: Apache-2.0
// One training in a process of its own.
#pragma once

#include <string>

#include "bench/training_race/curve.h"
#include "splatting/train/trainer.h"

namespace vesta::bench {

struct TrainingJob {
  std::string name;
  gs::TrainOptions options;
  // LM alone from this model, which took that many seconds of training; null: the whole training, from the points.
  const gs::SplatModel* start = nullptr;
  double seconds_before = 0;
};

struct TrainingRun {
  Curve curve;               // seconds count from the first iteration: loading left out, as evaluation is
  gs::SplatModel lm_start;   // the model at LM's iteration 0; without LM the one at the end
  double peak_mib = 0;       // of the whole process; the photographs, and job.start, were there before
  double adam_peak_mib = 0;  // until the last row of its Adam stage
};

// Trains on `threads` threads. Throws Error where that fails. The parent must not have started threads before.
TrainingRun TrainAlone(const gs::Scene& scene, const TrainingJob& job, int threads);

}  // namespace vesta::bench
