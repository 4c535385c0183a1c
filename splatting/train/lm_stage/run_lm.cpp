// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/lm_stage/run_lm.h"

#include <fmt/format.h>

#include <utility>

#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {
namespace {

Index NumBatches(const TrainingSession& session, const LmStageOptions& lm) {
  return ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(session.training_views().size()));
}

// What of LM's options cannot be done, or does nothing.
void MendOddities(TrainingSession& session, LmStageOptions* lm) {
  if (lm->iterations == 0) return;
  const bool is_plain = lm->batches == 1 && lm->batch_size == 0 && !lm->line_search && !IsCached(lm->jacobian);
  if (FindsCamerasByLm(session.options()) && !is_plain) {
    lm->batches = 1, lm->batch_size = 0, lm->line_search = false, lm->jacobian = JacobianKind::kRecompute;
    session.Note("LM that finds cameras takes all views as one batch, caches no Jacobian and searches no line");
  }
  const Index batches = NumBatches(session, *lm);
  if (batches < lm->batches) {
    session.Note(fmt::format("LM in {} of the lm.batches={} asked for: there are {} training views", batches,
                             lm->batches, session.training_views().size()));
  }
  if (lm->l1_weight == 0 && lm->ssim_weight == 0) {
    session.Note("LM has nothing to lower: lm.l1_weight and lm.ssim_weight are both 0");
  }
}

MemoryScene CountForLm(const TrainingSession& session, const StageRunners& stages, const SplatModel& model) {
  const TrainOptions& options = session.options();
  const bool has_cache = IsCached(options.lm.jacobian);
  const int some = stages.device_memory ? 8 : 4;
  const auto all = static_cast<int>(session.training_views().size());
  // Each counted view is built once: all only where LM is to be planned to the last byte.
  const bool is_exact = options.lm.iterations > 0 && (has_cache || options.memory.budget_gib > 0);
  const int counted = is_exact ? all : some;
  return session.memory().Count(ToKernelModel(model), counted, has_cache);
}

// Where there is no room for any, LM is not asked for any more; left_out says why.
LmPlan PlanLmStage(TrainingSession& session, const StageRunners& stages, const MemoryScene& counts,
                   std::string* left_out) {
  const TrainOptions& options = session.options();
  const bool finds_cameras = FindsCamerasByLm(options);
  LmPlan plan{options.lm};
  const StageMemory memory = MemoryToPlanBy(stages, options.memory);
  try {
    plan = finds_cameras ? PlanJointLm(counts, options, memory) : PlanLm(counts, options, memory);
  } catch (const Error& error) {
    // What Adam has made is not lost for want of memory.
    if (!options.adam.runs()) throw;
    *left_out = error.what();
  }
  if (!left_out->empty()) session.AdaptOptions().lm.iterations = 0;
  if (finds_cameras && !plan.eliminate_views) {
    session.Note("LM solves for cameras along with the splats: there is no room to eliminate them");
  }
  const JacobianKind asked = options.lm.jacobian, planned = plan.lm.jacobian;
  // A device always holds views where they fit, so that choice needs no note.
  const bool as_ever = stages.device_memory && asked == JacobianKind::kRebuild && planned == JacobianKind::kRecompute;
  if (planned != asked && !as_ever) {
    session.Note(fmt::format("LM with lm.jacobian={} in place of {}", schema::NameOf(planned, kJacobianKinds),
                             schema::NameOf(asked, kJacobianKinds)));
  }
  return plan;
}

}  // namespace

LmOutcome RunLm(TrainingSession& session, const StageRunners& stages, SplatModel* model) {
  const TrainOptions& options = session.options();
  MendOddities(session, &session.AdaptOptions().lm);
  LmOutcome outcome{
      .plan = {}, .batches = NumBatches(session, options.lm), .counts = CountForLm(session, stages, *model)};
  outcome.plan = PlanLmStage(session, stages, outcome.counts, &outcome.left_out);
  if (options.lm.iterations == 0 || session.early_end().has_reached_target() || session.early_end().ShouldStop()) {
    outcome.plan.bytes = 0;
    return outcome;
  }
  session.AdaptOptions().lm = outcome.plan.lm;
  outcome.report = FindsCamerasByLm(options) ? stages.joint_lm(session, *model, outcome.plan.eliminate_views)
                                             : stages.lm(session, *model, outcome.plan.hold_batches);
  return outcome;
}

}  // namespace vesta::gs
