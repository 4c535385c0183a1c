// SPDX-License-Identifier: Apache-2.0
// The viewer during a training: the model shown, the state of the training, and the pages' commands.
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

// The current model and its cameras, set by the training thread and read by rendering threads. Thread-safe.
class ShownModel {
 public:
  struct Shown {
    std::shared_ptr<const gs::SplatModel> model;  // null: none yet
    // How refinement has changed the training cameras of the scene; null: not refined.
    std::shared_ptr<const std::vector<gs::ViewUnknowns>> cameras;
    int version = 0;  // number of Put calls
  };

  // cameras: as Shown::cameras; empty: not refined.
  void Put(std::shared_ptr<const gs::SplatModel> model, const std::vector<gs::ViewUnknowns>& cameras = {}) {
    auto moved = cameras.empty() ? nullptr : std::make_shared<const std::vector<gs::ViewUnknowns>>(cameras);
    const std::lock_guard lock(mutex_);
    shown_.model.swap(model);  // freed after unlocking
    shown_.cameras.swap(moved);
    ++shown_.version;
  }
  // The current model. Records the time of the call.
  Shown Get() {
    looked_at_ = Clock::now().time_since_epoch().count();
    const std::lock_guard lock(mutex_);
    return shown_;
  }
  // Whether Get was called in the last `within` seconds.
  bool was_requested(std::chrono::duration<double> within) const {
    const Clock::time_point then{Clock::duration(looked_at_.load())};
    return then != Clock::time_point() && Clock::now() - then < within;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::mutex mutex_;
  Shown shown_;
  std::atomic<Clock::rep> looked_at_{0};
};

// Provides the state of a training as JSON, and passes the pages' commands to it.
class TrainingMonitor {
 public:
  // model: receives the training's model while a page is open; must outlive this object.
  explicit TrainingMonitor(ShownModel& model) : model_(model) {}

  // Adds functions of this object to the callbacks and keeps existing ones. The object must outlive the training.
  void Follow(gs::TrainCallbacks* callbacks);
  // Sets the status to over.
  void End();

  // Commands of the pages, which take effect after the current iteration. Thread-safe. A pause does not count as
  // training time.
  void Pause();
  void Resume();
  void Stop();
  void SaveCheckpoint();

  // The state for the page: "status" (running, paused, stopping, over), "stage", "iteration", "iterations", "seconds",
  // "seconds_left" (null: unknown), "cost" (the training loss), "psnr", "gaussians", "note", "message" (result of the
  // last checkpoint command), and the curves "costs" (training loss), "train_psnr" and "test_psnr": pairs of seconds
  // and value.
  std::string StateJson() const;
  Index gaussians() const;

 private:
  using Curve = std::vector<std::pair<double, double>>;

  void Observe(const gs::TrainProgress& progress);
  void Observe(const gs::HistoryRow& row);
  // The functions of gs::TrainWatch.
  bool WantsModel();
  bool Waits();
  const char* Status() const;

  ShownModel& model_;
  std::function<bool()> other_stop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool is_paused_ = false, is_stopped_ = false, is_over_ = false, wants_checkpoint_ = false;
  double shown_at_ = -1;  // time of the last copy of the model for the page; steady clock, seconds
  gs::TrainProgress progress_;
  TimeLeft time_left_;
  double seconds_left_ = 0;
  int every_ = 1, since_ = 0;  // one of every_ losses is kept; since_: losses after the last kept one
  Curve costs_, train_psnr_, test_psnr_;
  std::string message_;
};

}  // namespace vesta::app
