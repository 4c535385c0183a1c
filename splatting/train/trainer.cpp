// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/trainer.h"

#include <string>
#include <utility>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/memory/stage_bytes.h"
#include "splatting/train/adam_stage/adam_stage.h"
#include "splatting/train/adam_stage/trained_model.h"
#include "splatting/train/check_training.h"
#include "splatting/train/lm_stage/lm_solve.h"
#include "splatting/train/lm_stage/lm_stage.h"
#include "splatting/train/session/session.h"
#include "splatting/train/settings/train_options.h"
#include "splatting/train/settings/training_plan.h"

namespace vesta::gs {
namespace {

// Memory that the store of photographs may still fill.
double UnfilledMib(const Scene& scene) {
  if (!scene.photographs) return 0;
  return (scene.photographs->MostBytes() - scene.photographs->kept_bytes()) / kMib;
}

void NoteMissedTarget(TrainingSession& session) {
  session.Note(notes::kMissesTarget, session.history().held_out_psnr(), session.options().target_psnr);
}

void TakeFindings(TrainingSession& session, TrainResult* result) {
  result->eval_seconds = session.EvalSeconds();
  result->stopped = session.early_end().stopped();
  result->saved = session.interim().has_saved();
  if (session.early_end().misses_target() && !result->stopped) NoteMissedTarget(session);
  result->cameras = session.cameras().found();
  if (!result->cameras.empty()) {
    result->camera_changes =
        ChangesOf(result->model, session.cameras().given(), result->cameras, NearPlane(session.scene()));
  }
  result->history = session.history().Take();
  result->notes = session.TakeNotes();
}

struct TrainingStart {
  SplatModel model;
  bool is_given;  // the history starts with its quality
  BeforeTraining before;
};

// Takes the model of a saved LM stage, if the training resumes there.
void ResumeFromLm(TrainingSession& session, SplatModel* model) {
  if (session.saved().first_stage() != Stage::kLm || !session.saved().state()) return;
  *model = session.saved().Validate([&] { return ModelOfLmStage(*session.saved().state()); });
}

void NoteSampledEvaluations(TrainingSession& session) {
  const Index trained = NumTrainingViews(session.scene()), evaluated = session.options().evaluated_views;
  if (trained <= evaluated) return;
  session.Note(notes::kEvaluatesSomeViews, evaluated, trained);
}

// Runs the Adam stage, if any, and passes its result to the caller. Returns the reason to skip LM; else an empty
// string.
std::string RunAdam(TrainingSession& session, const StageRunners& stages, const TrainCallbacks& callbacks,
                    SplatModel* model) {
  if (!session.options().adam.runs() || session.saved().first_stage() != Stage::kAdam) return "";
  stages.adam(session, *model);
  const bool ends = session.early_end().stopped() || session.early_end().has_reached_target();
  std::string left_out;
  if (callbacks.before_lm && session.plan().lm.iterations > 0 && !ends) {
    try {
      callbacks.before_lm(*model);
    } catch (const Error& error) {
      left_out = error.what();
    }
  }
  if (session.processes().OnAny(!left_out.empty())) session.Decide().lm.iterations = 0;
  return left_out;
}

// Sets ResolvedPlan::max_gaussians to the number that fits into limited memory (memory/memory_plan.h). Throws Error if
// the given model does not fit.
void LimitGaussians(TrainingSession& session, const StageRunners& stages, const SplatModel& model) {
  const TrainOptions& options = session.options();
  if (options.memory.budget_gib == 0 && !stages.device_memory) return;
  const MemoryScene counts = session.memory().Count(ToKernelModel(model), 8, false);
  const StageMemory memory = MemoryForStages(stages, options.memory, session.plan().held_mib);
  const Index fit = PlanGaussians(counts, options, memory);
  if (stages.device_memory) {
    session.memory().SetSpareDeviceBytes(memory.bytes - memory.adam_bytes(counts.Scaled(fit), options));
  }
  const bool grows = options.density.enabled && options.adam.runs();
  if (options.memory.budget_gib == 0 && grows && fit < options.density.max_gaussians) {
    session.Note(notes::kFewerGaussiansFit, fit);
  }
  session.Decide().max_gaussians = fit;
}

// lm: outcome of the LM stage.
MemoryReport ReportOfMemory(TrainingSession& session, const StageRunners& stages, const SplatModel& model,
                            const LmOutcome& lm) {
  session.memory().NoteModel(model);
  const TrainOptions& options = session.options();
  const ResolvedPlan& plan = session.plan();
  const MemoryScene largest = lm.counts.Of(session.memory().largest_model());
  MemoryReport report;
  report.jacobian = plan.lm.jacobian;
  report.batches = static_cast<int>(lm.batches);
  if (!stages.device_memory) {
    report.predicted_mib = plan.held_mib + PredictedMib(largest, options, plan.lm_memory.bytes);
    return report;
  }
  report.predicted_mib = plan.held_mib + PredictedMibBesideDevice(largest, options);
  report.device_predicted_mib =
      PredictedDeviceMib(largest, options, plan.lm_memory.bytes, session.memory().device_snapshot_bytes());
  report.device_peak_mib = stages.device_memory().peak_bytes / kMib;
  return report;
}

TrainResult RunStages(const Scene& scene, TrainingStart start, const TrainOptions& asked,
                      const TrainCallbacks& callbacks, const StageRunners& stages) {
  CheckTraining(scene, asked, stages, ProcessGroup(callbacks.ranks));
  const double unfilled_mib = UnfilledMib(scene);  // before the session loads photographs
  TrainingSession session(scene, asked, start.before.seconds, callbacks);
  session.Decide().held_mib = start.before.mib + session.cameras().CopiedMib() + unfilled_mib;
  if (!stages.note.empty()) session.Note("{}", stages.note);
  const double begin = session.Seconds();
  SplatModel model = std::move(start.model);
  ResumeFromLm(session, &model);
  const double device_free = stages.device_memory ? stages.device_memory().free_bytes : 0;
  LimitGaussians(session, stages, model);
  SetRenderSettings(session.options(), &model), model.origin = scene.origin;
  NoteSampledEvaluations(session);
  // The first row describes the given model, to show the gain. Without Adam, LM records it.
  const bool tells_gain = start.is_given && session.options().adam.runs() && !callbacks.resume;
  if (tells_gain) session.history().Record(Stage::kLm, 0, ToKernelModel(model));
  TrainResult result;
  result.lm_left_out = RunAdam(session, stages, callbacks, &model);
  const double between = session.Seconds();
  session.cameras().DevelopAll();
  LmOutcome lm = RunLm(session, stages, &model);
  if (!lm.left_out.empty()) result.lm_left_out = lm.left_out;
  result.lm_report = std::move(lm.report);
  if (session.history().empty()) session.history().Record(Stage::kLm, 0, ToKernelModel(model));
  result.adam_seconds = between - begin;
  result.lm_seconds = session.Seconds() - between;
  result.memory = ReportOfMemory(session, stages, model, lm);
  result.memory.device_free_mib = device_free / kMib;
  result.model = std::move(model);
  TakeFindings(session, &result);
  return result;
}

SplatModel ModelOfAdamStage(const std::string& saved, const TrainOptions& options) {
  using B = CpuBackend<float>;
  AdamStageState<B> state{TrainedModel<B>(SplatModel(), Adam<B>(options.lr, options.adam.second_moment),
                                          DensityControl<Host>(options.density, 1), {}, 1),
                          ViewOrder(1, options.seed)};
  ArchiveReader reader(saved);
  reader(state);
  VESTA_CHECK(state.IsWhole(), "an inconsistent saved state of {} Gaussians", state.model.count());
  SplatModel model;
  state.model.DownloadResult(model);
  return model;
}

}  // namespace

StageRunners HostStages() { return {"cpu", RunAdamStage<CpuBackend<float>>, RunLmStage<CpuBackend<float>>}; }

SplatModel InitialModel(const Scene& scene, const TrainOptions& options) {
  SplatModel model =
      InitializeFromPoints(scene.points, scene.extent, *options.sh_degree, options.density.max_gaussians);
  const std::vector<Index> order = SpatialOrder(model);
  return InOrder(std::move(model), order);
}

TrainResult Train(const Scene& scene, const TrainOptions& options, const BeforeTraining& before,
                  const TrainCallbacks& callbacks, const StageRunners& stages) {
  const TrainOptions fitted = FitToScene(options, NumTrainingViews(scene));
  return RunStages(scene, {InitialModel(scene, fitted), false, before}, fitted, callbacks, stages);
}

TrainResult Refine(const Scene& scene, SplatModel model, const TrainOptions& options, const BeforeTraining& before,
                   const TrainCallbacks& callbacks, const StageRunners& stages) {
  const std::vector<Index> order = SpatialOrder(model);
  const splat::ModelLayout layout = model;
  TrainOptions without_growth = FitToScene(options, NumTrainingViews(scene));
  without_growth.density.enabled = false;
  TrainResult result =
      RunStages(scene, {InOrder(std::move(model), order), true, before}, without_growth, callbacks, stages);
  // After pruning, Gaussians stay in spatial order.
  if (result.model.layout() != layout) return result;
  // Otherwise neither stage reorders Gaussians.
  std::vector<Index> back(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) back[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  result.model = InOrder(std::move(result.model), back);
  return result;
}

SplatModel ModelOfCheckpoint(const Checkpoint& checkpoint, const TrainOptions& options) {
  SplatModel model;
  try {
    const bool is_of_adam = checkpoint.run.stage == Stage::kAdam;
    model = is_of_adam ? ModelOfAdamStage(checkpoint.stage_state, options) : ModelOfLmStage(checkpoint.stage_state);
  } catch (const Error&) {
    Fail(kBadFile, "{}: contains no training state with a splat to show", checkpoint.path);
  }
  SetRenderSettings(options, &model);
  return model;
}

}  // namespace vesta::gs
