// SPDX-License-Identifier: Apache-2.0
// The page of a training while it runs.
#pragma once

#include <array>
#include <string>

#include "apps/viewer/training_monitor.h"
#include "apps/viewer/viewer.h"

namespace vesta::app {

class TrainingView {
 public:
  // As Viewer's.
  TrainingView(const ViewerPlace& place, const gs::Scene& scene, const std::array<float, 3>& background)
      : viewer_(place, scene, background, model_, &monitor_) {}

  TrainingMonitor& monitor() { return monitor_; }
  std::string link() const { return viewer_.link(); }

 private:
  ShownModel model_;
  TrainingMonitor monitor_{model_};
  Viewer viewer_;
};

}  // namespace vesta::app
