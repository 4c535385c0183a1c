// SPDX-License-Identifier: Apache-2.0
// A training as pages see it and hold it: how it goes, as JSON, and what they ask of it.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/progress.h"
#include "apps/viewer/shown_model.h"
#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

class TrainingMonitor {
 public:
  // model: where the model goes while somebody looks.
  explicit TrainingMonitor(ShownModel& model) : model_(model) {}

  // Adds itself to the callbacks of a training; what they do already they still do. It must outlive the training.
  void Follow(gs::TrainCallbacks* callbacks);
  // There is nothing more to ask for.
  void End();

  // What pages ask for, from any thread. A pause begins after the iteration and its time does not count.
  void Pause();
  void Resume();
  void Stop();
  void SaveCheckpoint();

  // "status" (running, paused, stopping, over), "stage", "iteration", "iterations", "seconds", "seconds_left" (null:
  // not known), "cost", "psnr", "gaussians", "note", "message" (what became of the latest checkpoint asked for), and
  // the curves "costs", "train_psnr" and "test_psnr": pairs of seconds and value.
  std::string StateJson() const;
  Index gaussians() const;

 private:
  using Curve = std::vector<std::pair<double, double>>;

  void Observe(const gs::TrainProgress& progress);
  void Observe(const gs::HistoryRow& row);
  bool WantsModel();
  bool Waits();
  const char* Status() const;

  ShownModel& model_;
  std::function<bool()> stops_otherwise_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool is_paused_ = false, is_stopped_ = false, is_over_ = false, wants_checkpoint_ = false;
  double shown_at_ = -1;  // seconds of the system's clock
  gs::TrainProgress progress_;
  TimeLeft time_left_;
  double seconds_left_ = 0;
  int every_ = 1, since_ = 0;  // of how many observed costs one is kept
  Curve costs_, train_psnr_, test_psnr_;
  std::string message_;
};

}  // namespace vesta::app
