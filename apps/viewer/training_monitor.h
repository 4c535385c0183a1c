// SPDX-License-Identifier: Apache-2.0
// The model that pages show, and a training as pages see and control it.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/print.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

// The model that pages see, and the cameras it was made with, handed from the thread that has them to those that draw.
class ShownModel {
 public:
  struct Shown {
    std::shared_ptr<const gs::SplatModel> model;  // null: none yet
    // Of the training views, from where the scene has them; null: there.
    std::shared_ptr<const std::vector<gs::ViewUnknowns>> cameras;
    int version = 0;  // counts those that were put
  };

  // cameras: of each training view, or none: they are where the scene has them.
  void Put(std::shared_ptr<const gs::SplatModel> model, const std::vector<gs::ViewUnknowns>& cameras = {}) {
    auto moved = cameras.empty() ? nullptr : std::make_shared<const std::vector<gs::ViewUnknowns>>(cameras);
    const std::lock_guard lock(mutex_);
    shown_.model.swap(model);  // the old ones are freed without the lock
    shown_.cameras.swap(moved);
    ++shown_.version;
  }
  // For who looks at it, which is noted.
  Shown Look() {
    looked_at_ = Clock::now().time_since_epoch().count();
    const std::lock_guard lock(mutex_);
    return shown_;
  }
  // Whether somebody looked in so many of the last seconds.
  bool is_looked_at(std::chrono::duration<double> within) const {
    const Clock::time_point then{Clock::duration(looked_at_.load())};
    return then != Clock::time_point() && Clock::now() - then < within;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::mutex mutex_;
  Shown shown_;
  std::atomic<Clock::rep> looked_at_{0};
};

// A training as pages see it and hold it: how it goes, as JSON, and what they ask of it.
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
