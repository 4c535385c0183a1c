// SPDX-License-Identifier: Apache-2.0
// The LM stage as memory allows (memory/memory_plan.h).
#pragma once

#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/train/session/session.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::gs {

// What became of it.
struct LmOutcome {
  LmPlan plan;                // as it ran, or would have; bytes are 0 where it did not
  Index batches = 1;          // of views
  MemoryScene counts;         // of the model that it began with
  std::string report = {};    // the engine's
  std::string left_out = {};  // why there was no room for it; else empty
};

// LM from this model on, as asked for as far as there is room. Where there is too little: none if Adam has made
// something, else throws Error.
LmOutcome RunLm(TrainingSession& session, const StageRunners& stages, SplatModel* model);

}  // namespace vesta::gs
