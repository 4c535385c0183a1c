// The memory of a training, as it was foreseen and as it was.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/train/run_lm.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/train_result.h"

namespace vesta::gs {

// Of a training that ends with this model. lm: of its LM stage.
MemoryReport ReportOfMemory(TrainingSession& session, const StageRunners& stages, const SplatModel& model,
                            const LmOutcome& lm);

}  // namespace vesta::gs
