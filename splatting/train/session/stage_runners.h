// SPDX-License-Identifier: Apache-2.0
// What runs the stages of a training, and where.
#pragma once

#include <functional>
#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

class TrainingSession;

// Memory of the GPU.
struct DeviceMemoryUse {
  double free_bytes = 0;  // that could be allocated now, if nobody else does
  double peak_bytes = 0;  // most that was in use
};

// The two stages in one memory space (RunAdamStage, RunLmStage). Both leave the model at its best and record their last
// state; lm returns the engine's full report.
struct StageRunners {
  std::string device;
  std::function<void(TrainingSession&, SplatModel&)> adam;
  std::function<std::string(TrainingSession&, SplatModel&)> lm;
  std::function<DeviceMemoryUse()> device_memory = {};  // empty where both compute in the memory of the host
  std::string note = {};                                // where they run elsewhere than expected: why
};
// In the memory of the host.
StageRunners HostStages();
// On a GPU, in builds with CUDA. Throws Error, one line, where there is no GPU to use.
StageRunners DeviceStages();

}  // namespace vesta::gs
