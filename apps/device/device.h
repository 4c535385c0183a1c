// SPDX-License-Identifier: Apache-2.0
// The flag --device: CPU or GPU. Implemented in device_cuda.cpp, or in device_cpu.cpp without CUDA.
#pragma once

#include "apps/cli/flags.h"
#include "kernels/core/profile.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::app {

// Throws Error (one line) for --device=cuda without a usable GPU.
void CheckDevice(Device device);
// The training stages for the GPU if device is cuda, or if it is auto and a GPU is usable. Otherwise those for the CPU,
// with a note for the user if a GPU is present but not usable. Under mpirun, auto means the CPU. Throws as CheckDevice.
gs::StageRunners StagesOf(Device device);
// The clock for --profile. On a GPU it waits for pending work, so that phases are timed correctly.
Profile::Clock ProfileClock(Device device);

}  // namespace vesta::app
