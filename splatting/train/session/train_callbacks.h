// SPDX-License-Identifier: Apache-2.0
// Callbacks of a training: progress, results and requests.
#pragma once

#include <functional>
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
  int iteration = 0, iterations = 0;
  double seconds = 0;
  double cost = 0;  // running mean of the views' costs (Adam), cost over all training views (LM); per pixel and channel
  double psnr = 0;  // of the training views, latest value
  Index gaussians = 0;
  std::string note;  // LM: damping, gain ratio, PCG iterations, rejection of the step
};

// Where and when to save checkpoints.
struct CheckpointOptions {
  std::string path;  // written atomically
  Interval every;
  std::string origin;  // RunState::origin
};

// Prediction for the end of the Adam stage, made during the stage.
struct Prediction {
  bool is_first_guess = false;  // from speed alone: the growth of the Gaussians is not known yet
  double at_seconds = 0;        // training time so far (TrainingClock), with evaluations
  double seconds = 0;           // predicted training time at the end of the Adam stage, with evaluations
  double mib = 0;               // predicted maximal memory of the Adam stage, on the GPU if it runs there
  double gaussians = 0;
};

// A viewer that watches and pauses a training. The training thread calls these at the end of every iteration but the
// last. Each may be empty.
struct TrainWatch {
  // wants_model: true to receive the current model, which a GPU then downloads. show: receives the model and the
  // cameras of the training views (as in TrainResult::cameras).
  std::function<bool()> wants_model;
  std::function<void(const splat::Model<float>&, const std::vector<ViewUnknowns>& cameras)> show;
  // wants_checkpoint: true to save the state now, to CheckpointOptions::path. saved: receives the error, or an empty
  // string.
  std::function<bool()> wants_checkpoint;
  std::function<void(int iteration, const std::string& error)> saved;
  // True while the training is paused. It may block; no clock of the training counts this time. Called again after the
  // other functions.
  std::function<bool()> waits;
};

struct TrainCallbacks {
  std::function<void(const TrainProgress&)> progress;
  // Called about a second after the start, and when the growth of the Gaussians is known.
  std::function<void(const Prediction&)> predicted;
  // Called with every history row and its model, while the clock stands still.
  std::function<void(const HistoryRow&, const splat::Model<float>&)> evaluated;
  // Called after every iteration; true stops the training, which returns its current result.
  std::function<bool()> stop;
  // Called at the given interval with the model that the history would record, for snapshots.
  Interval snapshot_every;
  std::function<void(Stage, int iteration, const splat::Model<float>&)> snapshot;
  CheckpointOptions checkpoint;
  TrainWatch watch;
  // Called with Adam's result before LM begins. If it throws Error, LM is skipped for that reason.
  std::function<void(const SplatModel&)> before_lm;
  // Checkpoint to resume; null: start from the beginning. Must outlive the training.
  const Checkpoint* resume = nullptr;
  // Processes that train together; null: this process alone. All must make the same call. They divide the views of an
  // iteration and end with the same model. Only rank 0's other callbacks write and show results.
  Communicator* ranks = nullptr;
};

}  // namespace vesta::gs
