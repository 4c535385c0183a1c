// SPDX-License-Identifier: Apache-2.0
// --device: what a run computes on. device_cpu.cpp or device_cuda.cpp, as the build has CUDA or not.
#pragma once

#include "apps/cli/flags.h"
#include "kernels/core/profile.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::app {

// Throws Error, one line, for --device=cuda where that cannot be.
void CheckDevice(Device device);
// What trains: the GPU for cuda, and for auto where there is one that can, else the CPU, with a note where there is one
// that cannot. Several processes train on CPUs. Throws as CheckDevice.
gs::StageRunners StagesOf(Device device);
// For profiles of it.
Profile::Clock ProfileClock(Device device);

}  // namespace vesta::app
