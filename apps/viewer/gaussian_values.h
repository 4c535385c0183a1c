// SPDX-License-Identifier: Apache-2.0
// Values per Gaussian that the viewer's page shows as colours: removal cost and coverage (docs/glossary.md). Computing
// them takes several passes over all photographs. A background thread therefore does it when a page requests them.
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

// Position of each Gaussian on the colour scale, 0..1. rise: its removal cost. Position 0: the loss does not rise; 0.5:
// the rise is the median of the positive rises.
std::vector<float> RemovalCostColors(const std::vector<double>& rise);
// The same for coverage. Position 0: no view shows the Gaussian; 0.5: all views together show as much as one complete
// view of the Gaussian.
std::vector<float> CoverageColors(const std::vector<gs::Coverage>& coverage);

struct MeasuredValues {
  ShownModel::Shown of;                // the model of the values
  std::vector<float> scale_positions;  // per Gaussian, 0..1
};

class GaussianValues {
 public:
  // The scene must have training views and outlive this object. background: 0..1.
  GaussianValues(const gs::Scene& scene, const std::array<double, 3>& background)
      : scene_(scene), background_(background) {}
  // Cancels a computation in progress.
  ~GaussianValues() { ends_ = true; }
  GaussianValues(const GaussianValues&) = delete;
  GaussianValues& operator=(const GaussianValues&) = delete;

  // Returns the latest values, possibly of an earlier model; null: none yet. If they are not of `shown`, which must
  // have a model, also starts to compute the values of `shown`. Does not start while a computation runs, nor in the
  // pause after it, which is as long as the computation was. Throws Error if the computation for `shown` failed, for
  // example because a photograph cannot be read. Thread-safe.
  std::shared_ptr<const MeasuredValues> Get(GaussianValue value, const ShownModel::Shown& shown);

 private:
  using Clock = std::chrono::steady_clock;
  struct State {
    std::shared_ptr<const MeasuredValues> latest;
    bool is_measuring = false;
    Clock::time_point next_start{};  // end of the pause
    std::string failure;             // message of the latest failure
    int failed_version = 0;          // Shown::version of its model
  };

  std::vector<float> Measure(GaussianValue value, const ShownModel::Shown& shown) const;
  // The training views with the cameras of `shown`. Each photograph is copied only when it is used, so that few copies
  // are in memory.
  std::vector<gs::View> TrainingViews(const ShownModel::Shown& shown) const;
  void MeasureInto(State& state, GaussianValue value, const ShownModel::Shown& shown);

  const gs::Scene& scene_;
  const std::array<double, 3> background_;
  std::atomic<bool> ends_{false};
  std::mutex mutex_;
  std::map<GaussianValue, State> states_;
  Background background_work_;  // declared last: ends before the members it uses
};

}  // namespace vesta::app
