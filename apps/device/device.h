// SPDX-License-Identifier: Apache-2.0
// --device: the processor that a run computes on. Implemented in device_cuda.cpp, or in device_cpu.cpp without CUDA.
#pragma once

#include "apps/cli/flags.h"
#include "kernels/core/profile.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::app {

// Throws Error (one line) for --device=cuda if there is no usable GPU.
void CheckDevice(Device device);
// Returns the stages that run on the GPU if device is cuda, or if it is auto and a GPU is usable. Otherwise the stages
// run on the CPU. If a GPU is present but not usable, a note says so. Under mpirun, auto means the CPU. Throws as
// CheckDevice.
gs::StageRunners StagesOf(Device device);
// The clock for profiles of this device.
Profile::Clock ProfileClock(Device device);

}  // namespace vesta::app
