// SPDX-License-Identifier: Apache-2.0
// Runs one training in a child process.
#pragma once

#include <string>

#include "bench/training_race/curve.h"
#include "splatting/train/trainer.h"

namespace vesta::bench {

struct TrainingJob {
  std::string name;
  gs::TrainOptions options;
  // Null: train from the points of the scene. Otherwise run only the LM stage from this model, whose training took
  // seconds_before.
  const gs::SplatModel* start = nullptr;
  double seconds_before = 0;
};

struct TrainingRun {
  Curve curve;               // starts with seconds_before at the first iteration; without evaluations
  gs::SplatModel lm_start;   // at LM iteration 0; without an LM stage the final model
  double peak_mib = 0;       // of the child process, including photographs and job.start
  double adam_peak_mib = 0;  // until the last row of the Adam stage
};

// Throws Error if the training fails. The parent must not have started threads.
TrainingRun TrainAlone(const gs::Scene& scene, const TrainingJob& job, int threads);

}  // namespace vesta::bench
