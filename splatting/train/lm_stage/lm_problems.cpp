// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/lm_stage/lm_problems.h"

#include <algorithm>
#include <cstddef>

#include "problems/gaussian_splatting/lm/engine_options.h"

namespace vesta::gs {

SplatProblemOptions LmProblemOptions(const TrainingSession& session, const splat::ModelLayout& layout,
                                     const std::vector<float>& units) {
  const LmStageOptions& lm = session.plan().lm;
  SplatProblemOptions result = SplatProblemOptionsOf(lm, layout);
  result.background = session.options().background;
  result.batches = {lm.batches, lm.batch_size, lm.batch_choice, session.options().seed};
  result.rates = session.options().rates;
  result.units = std::make_shared<const std::vector<float>>(units);
  return result;
}

JointProblemOptions JointOptionsOf(const TrainingSession& session, const splat::ModelLayout& layout,
                                   const LmStageHeader& header) {
  const TrainOptions& options = session.options();
  JointProblemOptions problem{.splats = SplatProblemOptionsOf(session.plan().lm, layout),
                              .free = FreeBy(options.cameras.refine),
                              .prior = {.depth = 2 * session.scene().extent},
                              .eliminate_views = header.eliminates_views};
  problem.splats.background = options.background;
  problem.splats.rates = options.rates;
  problem.splats.units = std::make_shared<const std::vector<float>>(header.units);
  return problem;
}

// From cameras that are off, views eliminated come further by as many products, which take a fifth longer
// (docs/results/2026-11-25-joint-cameras.md).
vesta::LmOptions JointEngineOptions(const TrainingSession& session, const LmStageHeader& header) {
  vesta::LmOptions engine = LmEngineOptions(session.plan().lm);
  engine.batch_mode = BatchMode::kExact;
  engine.line_search.enabled = false;
  engine.normal_system.linear_solver = header.eliminates_views ? LinearSolverKind::kReducedPcg : LinearSolverKind::kPcg;
  return engine;
}

HostBuffer<float> JointStart(const JointLayout& layout, const SplatModel& model,
                             const std::vector<ViewUnknowns>& views) {
  HostBuffer<float> x(layout.num_parameters());
  std::copy(model.data.begin(), model.data.end(), x.begin());
  for (Index v = 0; v < layout.views; ++v)
    layout.SetUnknowns(views[static_cast<std::size_t>(v)], v, layout.RestOf(x.view()));
  return x;
}

}  // namespace vesta::gs
