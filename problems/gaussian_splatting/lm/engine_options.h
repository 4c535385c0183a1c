// The LM stage's options in the terms of the loss and of the engine.
#pragma once

#include "problems/gaussian_splatting/lm/options.h"
#include "solver/lm_options.h"

namespace vesta::gs {

// Of the cost.
PhotometricWeights LossOf(const LmStageOptions& lm);
vesta::LmOptions LmEngineOptions(const LmStageOptions& lm);

}  // namespace vesta::gs
