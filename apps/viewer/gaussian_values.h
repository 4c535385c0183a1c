// SPDX-License-Identifier: Apache-2.0
// Values per Gaussian that the page shows as colours: removal cost and coverage. They are measured in the background
// when a page first requests them, because this takes several passes over all photographs.
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

// A position on the colour scale, 0..1, for each Gaussian. rise: the removal cost. 0: the loss does not rise; 0.5: the
// median of the positive rises.
std::vector<float> RemovalCostColors(const std::vector<double>& rise);
// 0: the views show nothing of the Gaussian; 0.5: they show as much in total as one complete view of it.
std::vector<float> CoverageColors(const std::vector<gs::Coverage>& coverage);

struct MeasuredValues {
  ShownModel::Shown of;       // the model that was measured
  std::vector<float> places;  // of its Gaussians on the colour scale, 0..1
};

class GaussianValues {
 public:
  // The scene must outlive this object. It must have training views. background: colour, 0..1.
  GaussianValues(const gs::Scene& scene, const std::array<double, 3>& background)
      : scene_(scene), background_(background) {}
  // Cancels a measurement in progress.
  ~GaussianValues() { ends_ = true; }
  GaussianValues(const GaussianValues&) = delete;
  GaussianValues& operator=(const GaussianValues&) = delete;

  // Returns the latest values, perhaps of an earlier model; null: none yet. Thread-safe. If they are not of `shown`,
  // which must have a model, starts a measurement, unless one is running or more than half of the time goes into
  // measuring. Throws Error if a photograph can no longer be read.
  std::shared_ptr<const MeasuredValues> Get(GaussianValue value, const ShownModel::Shown& shown);

 private:
  using Clock = std::chrono::steady_clock;
  struct State {
    std::shared_ptr<const MeasuredValues> latest;
    bool is_measuring = false;
    Clock::time_point next_start{};
    std::string failure;  // of the latest measurement
    int failed_version = 0;
  };

  std::vector<float> Measure(GaussianValue value, const ShownModel::Shown& shown) const;
  // The training views with their current cameras. Photographs are not kept in memory but copied one by one.
  std::vector<gs::View> TrainingViews(const ShownModel::Shown& shown) const;
  void MeasureInto(State& state, GaussianValue value, const ShownModel::Shown& shown);

  const gs::Scene& scene_;
  const std::array<double, 3> background_;
  std::atomic<bool> ends_{false};
  std::mutex mutex_;
  std::map<GaussianValue, State> states_;
  Background background_work_;  // last: ends before the members that it uses
};

}  // namespace vesta::app
