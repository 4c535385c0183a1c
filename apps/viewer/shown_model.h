// SPDX-License-Identifier: Apache-2.0
// The model that pages see, and the cameras it was made with, handed from the thread that has them to those that draw.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::app {

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

}  // namespace vesta::app
