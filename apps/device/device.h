// SPDX-License-Identifier: Apache-2.0
// --device: the processor that a run computes on. Implemented in device_cuda.cpp, or in device_cpu.cpp without CUDA.
#pragma once

#include "apps/cli/flags.h"
#include "kernels/core/profile.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::app {

// Throws Error (one line) for --device=cuda if there is no usable GPU.
void CheckDevice(Device device);
// The training stages: on the GPU for cuda, and for auto if a GPU is usable; else on the CPU, with a note if a GPU is
// present but not usable. Under mpirun, auto means the CPU. Throws as CheckDevice.
gs::StageRunners StagesOf(Device device);
// The clock for profiles of this device.
Profile::Clock ProfileClock(Device device);

}  // namespace vesta::app
