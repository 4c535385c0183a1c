// SPDX-License-Identifier: Apache-2.0
// The memory of a training: how many Gaussians fit, and the report of what was predicted and used.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/train/lm_stage/lm_stage.h"
#include "splatting/train/session/session.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/train_result.h"

namespace vesta::gs {

// Decides ResolvedPlan::max_gaussians: no more than fit, where memory is limited (memory/memory_plan.h). Throws Error
// where even the given model does not fit.
void LimitGaussians(TrainingSession& session, const StageRunners& stages, const SplatModel& model);

// At the end of a training that leaves this model. lm: of its LM stage.
MemoryReport ReportOfMemory(TrainingSession& session, const StageRunners& stages, const SplatModel& model,
                            const LmOutcome& lm);

}  // namespace vesta::gs
