// How long a stage of training will still take, by how long it has taken so far.
#pragma once

#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

class TimeLeft {
 public:
  // After an iteration. Returns seconds; NaN where nothing has been seen of the stage yet.
  double Observe(const gs::TrainProgress& progress);

 private:
  bool started_ = false;
  gs::Stage stage_ = gs::Stage::kAdam;
  int start_iteration_ = 0;  // of the stage, as far as it was seen
  double start_seconds_ = 0;
  double latest_seconds_ = 0;
};

}  // namespace vesta::app
