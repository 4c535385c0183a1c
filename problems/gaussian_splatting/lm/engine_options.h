// The LM stage's options in the engine's terms.
#pragma once

#include "problems/gaussian_splatting/lm/options.h"
#include "solver/lm_options.h"

namespace vesta::gs {

vesta::LmOptions LmEngineOptions(const LmStageOptions& lm);

}  // namespace vesta::gs
