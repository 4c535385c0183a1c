// SPDX-License-Identifier: Apache-2.0
// The stages of a training in one memory space.
#pragma once

#include <functional>
#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

class TrainingSession;

struct DeviceMemoryUse {
  double free_bytes = 0;  // available now, if no other program allocates
  double peak_bytes = 0;  // maximum so far
};

// The two stages in one memory space (RunAdamStage, RunLmStage). Each trains the model in place and adds its last
// evaluation to the history; lm returns the solver's full report.
struct StageRunners {
  std::string device;  // "cpu" or "cuda"
  std::function<void(TrainingSession&, SplatModel&)> adam;
  std::function<std::string(TrainingSession&, SplatModel&)> lm;
  std::function<DeviceMemoryUse()> device_memory = {};  // empty in host memory
  std::string note = {};                                // why they run on another device than expected
};
StageRunners HostStages();
// Available in builds with CUDA. Throws Error without a usable GPU.
StageRunners DeviceStages();

}  // namespace vesta::gs
