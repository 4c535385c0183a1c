// SPDX-License-Identifier: Apache-2.0
// The LM stage's options in the terms of the loss, of the problem and of the engine.
#pragma once

#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "solver/lm_options.h"

namespace vesta::gs {

// Of the cost.
PhotometricWeights LossOf(const LmStageOptions& lm);
// Of a model so laid out; batches, background, rates and units are the caller's to set.
SplatProblemOptions SplatProblemOptionsOf(const LmStageOptions& lm, const splat::ModelLayout& layout);
vesta::LmOptions LmEngineOptions(const LmStageOptions& lm);

}  // namespace vesta::gs
