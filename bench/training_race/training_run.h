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
  // Null: train from the points of the scene. Otherwise run only the LM stage, starting with this model, whose training
  // took seconds_before.
  const gs::SplatModel* start = nullptr;
  double seconds_before = 0;
};

struct TrainingRun {
  Curve curve;               // its seconds start with seconds_before at the first iteration and exclude evaluations
  gs::SplatModel lm_start;   // the model at LM iteration 0; without an LM stage the final model
  double peak_mib = 0;       // peak memory of the child process, including the photographs and job.start
  double adam_peak_mib = 0;  // peak memory until the last row of the Adam stage
};

// Trains with `threads` threads. Throws Error if that fails. The parent must not have started threads before.
TrainingRun TrainAlone(const gs::Scene& scene, const TrainingJob& job, int threads);

}  // namespace vesta::bench
