// SPDX-License-Identifier: Apache-2.0
// The memory of a training, as it was foreseen and as it was.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/train/lm_stage/run_lm.h"
#include "splatting/train/session/session.h"
#include "splatting/train/session/train_result.h"

namespace vesta::gs {

// Of a training that ends with this model. lm: of its LM stage.
MemoryReport ReportOfMemory(TrainingSession& session, const StageRunners& stages, const SplatModel& model,
                            const LmOutcome& lm);

}  // namespace vesta::gs
