// SPDX-License-Identifier: Apache-2.0
// Runs one training in its own process.
#pragma once

#include <string>

#include "bench/training_race/curve.h"
#include "splatting/train/trainer.h"

namespace vesta::bench {

struct TrainingJob {
  std::string name;
  gs::TrainOptions options;
  // If not null, run only the LM stage from this model, which took seconds_before to train. If null, train from the
  // points.
  const gs::SplatModel* start = nullptr;
  double seconds_before = 0;
};

struct TrainingRun {
  Curve curve;               // seconds start at the first iteration and exclude loading and evaluation
  gs::SplatModel lm_start;   // the model at LM iteration 0; without LM stage the final model
  double peak_mib = 0;       // of the whole process, including the photographs and job.start
  double adam_peak_mib = 0;  // until the last row of the Adam stage
};

// Trains with `threads` threads. Throws Error if that fails. The parent must not have started threads before.
TrainingRun TrainAlone(const gs::Scene& scene, const TrainingJob& job, int threads);

}  // namespace vesta::bench
