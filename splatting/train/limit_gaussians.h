// SPDX-License-Identifier: Apache-2.0
// How many Gaussians the Adam stage may come to.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/train/session/session.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::gs {

// No more than there is room for, where memory is limited (memory/memory_plan.h). Throws Error where there is none for
// the model.
void LimitGaussians(TrainingSession& session, const StageRunners& stages, const SplatModel& model);

}  // namespace vesta::gs
