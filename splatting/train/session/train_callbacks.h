// SPDX-License-Identifier: Apache-2.0
// What a training tells its caller on the way, and is asked by it.
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

// After every iteration of either stage.
struct TrainProgress {
  Stage stage = Stage::kAdam;
  int iteration = 0, iterations = 0;
  double seconds = 0;
  double cost = 0;  // running mean of the views' costs (Adam), cost over all training views (LM); per pixel and channel
  double psnr = 0;  // of the training views, latest known
  Index gaussians = 0;
  std::string note;  // LM: damping, gain ratio, whether the step was accepted
};

// Where the state of the training is saved, so that a later run goes on from there.
struct CheckpointOptions {
  std::string path;  // a file; written whole or not at all
  Interval every;
  std::string origin;  // RunState::origin
};

// What the training will take up to the end of the Adam stage, foreseen on the way.
struct Prediction {
  bool is_first_guess = false;  // from speed alone: how the Gaussians will grow has not been seen yet
  double at_seconds = 0;        // of the training so far (TrainingClock), evaluation included
  double seconds = 0;           // the same at the end of the Adam stage, evaluation included
  double mib = 0;               // most that the Adam stage holds, of a GPU where it runs on one
  double gaussians = 0;
};

// Who watches a training and holds it. All are called at the end of iterations that others follow, by the thread that
// trains; each may be empty.
struct TrainWatch {
  // Whether to be shown the model now, which on a GPU is downloaded for it; and the cameras of the training views as
  // they are with it, as TrainResult::cameras has them.
  std::function<bool()> wants_model;
  std::function<void(const splat::Model<float>&, const std::vector<ViewUnknowns>& cameras)> show;
  // Whether the state is to be saved now, to CheckpointOptions::path and what became of it: why not, else empty.
  std::function<bool()> wants_checkpoint;
  std::function<void(int iteration, const std::string& error)> saved;
  // Whether the training is paused: then it may take its time, which no clock of the training counts, and is asked
  // again, after all the others.
  std::function<bool()> waits;
};

struct TrainCallbacks {
  std::function<void(const TrainProgress&)> progress;
  // A second after the start, and when it is seen how the Gaussians grow.
  std::function<void(const Prediction&)> predicted;
  // With every row of the history, and the model that it is of. The clock stands still.
  std::function<void(const HistoryRow&, const splat::Model<float>&)> evaluated;
  // Asked after every iteration; true ends training there, with the result as it stands.
  std::function<bool()> stop;
  // With the model on the way, as it is shown in the history.
  Interval snapshot_every;
  std::function<void(Stage, int iteration, const splat::Model<float>&)> snapshot;
  CheckpointOptions checkpoint;
  TrainWatch watch;
  // With Adam's result, before LM begins. LM is left out where it throws Error, for the reason that it gives.
  std::function<void(const SplatModel&)> before_lm;
  // To go on from; null: from the start. Must outlive the training.
  const Checkpoint* resume = nullptr;
  // Processes that train together, all by the same call; null: this one alone. They divide the views of an iteration
  // among them and end with the same model. Only the first one's other callbacks write and show.
  Communicator* ranks = nullptr;
};

}  // namespace vesta::gs
