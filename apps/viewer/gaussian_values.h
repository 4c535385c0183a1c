// SPDX-License-Identifier: Apache-2.0
// What the Gaussians of a model are to the training views, for pages that show it as colours. Measured beside the
// program when a page first asks for it, since it takes as long as some passes over all photographs.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "apps/viewer/training_monitor.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/pruning/coverage.h"

namespace vesta::app {

enum class GaussianValue { kRemovalCost, kCoverage };

// By Gaussian a place on a scale from 0 to 1. Of what the cost rises by without it: 0 where it does not rise, in the
// middle the median of all others.
std::vector<float> RemovalCostColors(const std::vector<double>& rise);
// 0 where the views show nothing of it, in the middle where they show as much of it as one image could hold of all.
std::vector<float> CoverageColors(const std::vector<gs::Coverage>& support);

struct MeasuredValues {
  ShownModel::Shown of;
  std::vector<float> places;  // of its Gaussians
};

class GaussianValues {
 public:
  // The scene must outlive it and have training views. background: behind all Gaussians, 0..1.
  GaussianValues(const gs::Scene& scene, const std::array<double, 3>& background)
      : scene_(scene), background_(background) {}
  // What is being measured is broken off.
  ~GaussianValues() { ends_ = true; }
  GaussianValues(const GaussianValues&) = delete;
  GaussianValues& operator=(const GaussianValues&) = delete;

  // The latest that were measured, perhaps of an earlier model; null: none yet. From any thread. Where they are not of
  // `shown`, which has a model, those are measured now, unless others are, or have been for more than half of the time.
  // Throws Error where a photograph that they need cannot be read any more.
  std::shared_ptr<const MeasuredValues> Ask(GaussianValue value, const ShownModel::Shown& shown);

 private:
  using Clock = std::chrono::steady_clock;
  struct State {
    std::shared_ptr<const MeasuredValues> latest;
    bool is_measuring = false;
    Clock::time_point rests_until{};
    std::string failure;  // of the latest try
    int failed_version = 0;
  };

  std::vector<float> Measure(GaussianValue value, const ShownModel::Shown& shown) const;
  // Where their cameras stand, without photographs in memory: they are copied one by one.
  std::vector<gs::View> TrainingViews(const ShownModel::Shown& shown) const;
  void MeasureInto(State& state, GaussianValue value, const ShownModel::Shown& shown);

  const gs::Scene& scene_;
  const std::array<double, 3> background_;
  std::atomic<bool> ends_{false};
  std::mutex mutex_;
  std::map<GaussianValue, State> states_;
  Background background_work_;  // ends before what it works on
};

}  // namespace vesta::app
