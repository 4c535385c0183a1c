// The two stages as memory allows (memory/memory_plan.h).
#pragma once

#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/trainer.h"

namespace vesta::gs {

// Before the Adam stage: no more Gaussians than there is room for, where memory is limited.
void LimitGaussians(TrainingSession& session, const StageRunners& stages, const SplatModel& model);

// LM from this model on, as asked for as far as there is room. Where there is too little: none if Adam has made
// something (TrainResult::lm_left_out), else throws Error. The result also says what memory was foreseen, for both
// stages.
void RunLm(TrainingSession& session, const StageRunners& stages, SplatModel* model, TrainResult* result);

}  // namespace vesta::gs
