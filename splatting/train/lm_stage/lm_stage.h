// SPDX-License-Identifier: Apache-2.0
// Stage two: Levenberg-Marquardt on all training views, by the engine, planned as memory allows (memory/memory_plan.h).
#pragma once

#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/train/lm_stage/lm_problems.h"
#include "splatting/train/session/session.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::gs {

// The stage in one memory space, by the session's plan. Leaves the model, and cameras where it finds them, at their
// best and records their last state. Returns the engine's full report. Throws as SolveLmStage.
template <class B>
std::string RunLmStage(TrainingSession& session, SplatModel& model) {
  LmStart start(session, model);
  if (!FindsCamerasByLm(session.options())) {
    SplatLm<B> problem(session, model, start.header);
    return SolveLmStage<B>(session, model, start, problem);
  }
  if (!start.saved()) start.header.eliminates_views = session.plan().lm_memory.eliminate_views;
  JointLm<B> problem(session, model, start.header);
  return SolveLmStage<B>(session, model, start, problem);
}

extern template std::string RunLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

// The result of the stage.
struct LmOutcome {
  Index batches = 1;          // of views
  MemoryScene counts;         // of the model that it began with
  std::string report = {};    // the engine's
  std::string left_out = {};  // why there was no room for it; else empty
};

// Plans the stage and runs it from this model on, as asked for as far as there is room. Where there is too little: none
// if Adam has made something, else throws Error.
LmOutcome RunLm(TrainingSession& session, const StageRunners& stages, SplatModel* model);

}  // namespace vesta::gs
