// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/training_monitor.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::app {
namespace {

using Json = nlohmann::json;

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// null for NaN, which JSON does not have.
Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// Keeps every second point.
void Thin(std::vector<std::pair<double, double>>* curve) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < curve->size(); i += 2) (*curve)[kept++] = (*curve)[i];
  curve->resize(kept);
}

// Calls both functions; the first may be empty.
template <class First, class Second>
auto Both(First first, Second second) {
  return [first = std::move(first), second = std::move(second)](const auto&... args) {
    if (first) first(args...);
    second(args...);
  };
}

}  // namespace

void TrainingMonitor::Follow(gs::TrainCallbacks* callbacks) {
  callbacks->progress = Both(callbacks->progress, [this](const gs::TrainProgress& progress) { Observe(progress); });
  callbacks->evaluated =
      Both(callbacks->evaluated, [this](const gs::HistoryRow& row, const splat::Model<float>&) { Observe(row); });
  other_stop_ = callbacks->stop;
  callbacks->stop = [this] {
    if (other_stop_ && other_stop_()) return true;
    const std::lock_guard lock(mutex_);
    return is_stopped_;
  };
  callbacks->watch.wants_model = [this] { return WantsModel(); };
  callbacks->watch.show = [this](const splat::Model<float>& model, const std::vector<gs::ViewUnknowns>& cameras) {
    model_.Put(std::make_shared<const gs::SplatModel>(gs::CopyOf(model)), cameras);
  };
  callbacks->watch.wants_checkpoint = [this] {
    const std::lock_guard lock(mutex_);
    return std::exchange(wants_checkpoint_, false);
  };
  callbacks->watch.saved = [this, path = callbacks->checkpoint.path](int iteration, const std::string& error) {
    const std::lock_guard lock(mutex_);
    message_ = error.empty() ? "checkpoint of iteration " + std::to_string(iteration) + " saved to " + path : error;
  };
  callbacks->watch.waits = [this] { return Waits(); };
}

void TrainingMonitor::Observe(const gs::TrainProgress& progress) {
  constexpr std::size_t kMostPoints = 400;
  const std::lock_guard lock(mutex_);
  progress_ = progress;
  seconds_left_ = time_left_.Observe(progress);
  if (++since_ < every_) return;
  since_ = 0;
  costs_.emplace_back(progress.seconds, progress.cost);
  if (costs_.size() < kMostPoints) return;
  Thin(&costs_);
  every_ *= 2;
}

void TrainingMonitor::Observe(const gs::HistoryRow& row) {
  const std::lock_guard lock(mutex_);
  train_psnr_.emplace_back(row.seconds, row.train.psnr);
  if (std::isfinite(row.test.psnr)) test_psnr_.emplace_back(row.seconds, row.test.psnr);
}

bool TrainingMonitor::WantsModel() {
  // A page requests the state twice per second. Copying a large model takes several iterations.
  constexpr std::chrono::seconds kLooks{2};
  constexpr double kBetween = 0.5;  // seconds
  if (!model_.was_requested(kLooks)) return false;
  const std::lock_guard lock(mutex_);
  const double now = Now();
  if (now - shown_at_ < kBetween) return false;
  shown_at_ = now;
  return true;
}

bool TrainingMonitor::Waits() {
  constexpr std::chrono::milliseconds kSlice{50};  // interval for checking Ctrl-C and whether a page is open
  std::unique_lock lock(mutex_);
  if (!is_paused_ || is_stopped_) return false;
  if (other_stop_ && other_stop_()) return false;
  changed_.wait_for(lock, kSlice);
  return true;
}

void TrainingMonitor::End() {
  const std::lock_guard lock(mutex_);
  is_over_ = true;
}
void TrainingMonitor::Pause() {
  const std::lock_guard lock(mutex_);
  is_paused_ = true;
}
void TrainingMonitor::Resume() {
  const std::lock_guard lock(mutex_);
  is_paused_ = false;
  changed_.notify_all();
}
void TrainingMonitor::Stop() {
  const std::lock_guard lock(mutex_);
  is_stopped_ = true;
  changed_.notify_all();
}
void TrainingMonitor::SaveCheckpoint() {
  const std::lock_guard lock(mutex_);
  wants_checkpoint_ = true;
  message_ = "a checkpoint is saved after this iteration";
  changed_.notify_all();
}

const char* TrainingMonitor::Status() const {
  if (is_over_) return "over";
  if (is_stopped_) return "stopping";
  return is_paused_ ? "paused" : "running";
}

Index TrainingMonitor::gaussians() const {
  const std::lock_guard lock(mutex_);
  return progress_.gaussians;
}

std::string TrainingMonitor::StateJson() const {
  const std::lock_guard lock(mutex_);
  const gs::TrainProgress& p = progress_;
  const Json json = {{"status", Status()},        {"stage", gs::StageName(p.stage)},
                     {"iteration", p.iteration},  {"iterations", p.iterations},
                     {"seconds", p.seconds},      {"seconds_left", Number(seconds_left_)},
                     {"cost", Number(p.cost)},    {"psnr", Number(p.psnr)},
                     {"gaussians", p.gaussians},  {"note", p.note},
                     {"message", message_},       {"costs", costs_},
                     {"train_psnr", train_psnr_}, {"test_psnr", test_psnr_}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace vesta::app
