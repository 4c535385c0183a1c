// SPDX-License-Identifier: Apache-2.0
// Callbacks of a training: progress, results and requests.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "kernels/ranks/communicator.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/train_result.h"
#include "splatting/train/session/training_clock.h"

namespace vesta::gs {

// Reported after every iteration of either stage.
struct TrainProgress {
  Stage stage = Stage::kAdam;
  int iteration = 0, iterations = 0;  // done; expected in total, or 0 while unknown
  double seconds = 0;                 // without evaluations
  double cost = 0;  // running mean of the views' costs (Adam), cost over all training views (LM); per pixel and channel
  double psnr = 0;  // of the training views, latest value
  Index gaussians = 0;
  std::string note;  // LM: damping, gain ratio, PCG iterations, rejection of the step
  // Predicted seconds to the end of the stage, with evaluations; NaN: not predicted.
  double seconds_left = std::numeric_limits<double>::quiet_NaN();
};

struct CheckpointOptions {
  std::string path;  // written atomically
  Interval every;
  std::string origin;  // RunState::origin
};

// Forecast during the Adam stage for its end.
struct Prediction {
  bool is_first_guess = false;  // from speed alone, not growth
  double at_seconds = 0;        // training time so far, with evaluations
  double seconds = 0;           // predicted training time at the end, with evaluations
  double mib = 0;               // predicted peak memory of the Adam stage, on the GPU if it runs there
  double gaussians = 0;         // predicted number at the end
};

// A viewer that watches and pauses a training. The training thread calls these functions at the end of every iteration
// but the last. Each may be empty.
struct TrainWatch {
  // wants_model: true to receive the current model (downloaded from a GPU if necessary). show: receives the model, and
  // the cameras of the training views (as in TrainResult::cameras).
  std::function<bool()> wants_model;
  std::function<void(const splat::Model<float>&, const std::vector<ViewUnknowns>& cameras)> show;
  // wants_checkpoint: true to write a checkpoint now, to CheckpointOptions::path. saved: called after every attempt,
  // with the error message or an empty string.
  std::function<bool()> wants_checkpoint;
  std::function<void(int iteration, const std::string& error)> saved;
  // True to pause the training; called repeatedly, with the functions above in between. It may block. The time counts
  // neither as training nor as evaluation.
  std::function<bool()> waits;
};

struct TrainCallbacks {
  std::function<void(const TrainProgress&)> progress;
  // Called about a second after the start, and when the growth of the Gaussians is known.
  std::function<void(const Prediction&)> predicted;
  // Called with every history row and its model, while the training clock is paused.
  std::function<void(const HistoryRow&, const splat::Model<float>&)> evaluated;
  // Called after every iteration. If true, the training stops and returns its current result.
  std::function<bool()> stop;
  // snapshot: called every snapshot_every, for example to save the model that an evaluation would use.
  Interval snapshot_every;
  std::function<void(Stage, int iteration, const splat::Model<float>&)> snapshot;
  CheckpointOptions checkpoint;
  TrainWatch watch;
  // Called with Adam's result before LM. If it throws Error, LM is skipped for that reason.
  std::function<void(const SplatModel&)> before_lm;
  // Checkpoint to resume from, or null. Must outlive the training.
  const Checkpoint* resume = nullptr;
  // Processes that train together; null: this process alone. All must call Train or Refine with the same scene and
  // options. They divide the views of an iteration and end with the same model. Only rank 0 should output results in
  // its other callbacks.
  Communicator* ranks = nullptr;
};

}  // namespace vesta::gs
