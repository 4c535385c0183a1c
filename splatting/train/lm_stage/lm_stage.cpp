// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/lm_stage/lm_stage.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {
namespace {

Index NumBatches(const TrainingSession& session) {
  const LmStageOptions& lm = session.plan().lm;
  return ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(session.training_views().size()));
}

// Replaces unsupported LM options, and notes options without effect.
void NormalizeLmOptions(TrainingSession& session) {
  LmStageOptions& lm = session.Decide().lm;
  if (lm.iterations == 0) return;
  const bool is_plain = lm.batches == 1 && lm.batch_size == 0 && !lm.line_search && !IsCached(lm.jacobian);
  if (FindsCamerasByLm(session.options()) && !is_plain) {
    lm.batches = 1, lm.batch_size = 0, lm.line_search = false, lm.jacobian = JacobianKind::kCachedViews;
    session.Note(notes::kLmWithCamerasIsPlain);
  }
  const Index batches = NumBatches(session);
  if (batches < lm.batches) {
    session.Note(notes::kLmInFewerBatches, batches, lm.batches, session.training_views().size());
  }
  if (lm.l1_weight == 0 && lm.ssim_weight == 0) {
    session.Note(notes::kLmLowersNothing);
  }
}

MemoryScene CountForLm(const TrainingSession& session, const StageRunners& stages, const SplatModel& model) {
  const LmStageOptions& lm = session.plan().lm;
  const bool has_cache = IsCached(lm.jacobian);
  const int some = stages.device_memory ? 8 : 4;
  const auto all = static_cast<int>(session.training_views().size());
  // Counting builds each view once: all views only if LM memory must be planned exactly.
  const bool is_exact = lm.iterations > 0 && (has_cache || session.options().memory.budget_gib > 0);
  const int counted = is_exact ? all : some;
  return session.memory().Count(ToKernelModel(model), counted, has_cache);
}

// Returns the reason if LM does not fit, else an empty string.
std::string PlanWithinMemory(TrainingSession& session, const StageRunners& stages, const MemoryScene& counts) {
  const TrainOptions& options = session.options();
  ResolvedPlan& plan = session.Decide();
  const bool finds_cameras = FindsCamerasByLm(options);
  const StageMemory memory = MemoryForStages(stages, options.memory, plan.held_mib);
  const JacobianKind asked = plan.lm.jacobian;
  try {
    plan.lm_memory = finds_cameras ? PlanJointLm(counts, options, memory) : PlanLm(counts, plan.lm, memory);
  } catch (const Error& error) {
    // Keep the result of Adam.
    if (!options.adam.runs()) throw;
    plan.lm.iterations = 0;
    return error.what();
  }
  if (finds_cameras) {
    if (!plan.lm_memory.eliminate_views) {
      session.Note(notes::kLmEliminatesNothing);
    }
    return "";
  }
  const JacobianKind planned = plan.lm.jacobian = plan.lm_memory.jacobian;
  // A device always caches views if they fit: no note.
  const bool as_ever =
      stages.device_memory && asked == JacobianKind::kOnTheFly && planned == JacobianKind::kCachedViews;
  if (planned != asked && !as_ever) {
    session.Note(notes::kLmWithOtherJacobian, schema::NameOf(planned, kJacobianKinds),
                 schema::NameOf(asked, kJacobianKinds));
  }
  return "";
}

}  // namespace

template std::string RunLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

LmOutcome RunLm(TrainingSession& session, const StageRunners& stages, SplatModel* model) {
  NormalizeLmOptions(session);
  LmOutcome outcome{.batches = NumBatches(session), .counts = CountForLm(session, stages, *model)};
  outcome.left_out = PlanWithinMemory(session, stages, outcome.counts);
  if (session.plan().lm.iterations == 0 || session.early_end().has_reached_target() ||
      session.early_end().ShouldStop()) {
    session.Decide().lm_memory.bytes = 0;
    return outcome;
  }
  outcome.report = stages.lm(session, *model);
  return outcome;
}

SplatProblemOptions LmProblemOptions(const TrainingSession& session, const splat::ModelLayout& layout,
                                     const std::vector<float>& units) {
  const LmStageOptions& lm = session.plan().lm;
  SplatProblemOptions result = SplatProblemOptionsOf(lm, layout);
  result.background = session.options().background;
  result.batches = {lm.batches, lm.batch_size, lm.batch_choice, session.options().seed};
  result.lr = session.options().lr;
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
  problem.splats.lr = options.lr;
  problem.splats.units = std::make_shared<const std::vector<float>>(header.units);
  return problem;
}

// With inaccurate cameras, eliminating the views reaches a lower cost with the same number of products, each a fifth
// slower (docs/decisions/joint-camera-lm.md).
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
