// SPDX-License-Identifier: Apache-2.0
// The stages of training on a GPU.
#pragma once

#include "splatting/train/session/stage_runners.h"

namespace vesta::gs {

// For Train and Refine. Throws Error, one line, where there is no GPU to use.
StageRunners DeviceStages();

}  // namespace vesta::gs
