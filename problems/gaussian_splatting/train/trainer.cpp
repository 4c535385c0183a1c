#include "problems/gaussian_splatting/train/trainer.h"

#include <fmt/format.h>

#include <utility>

#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/spatial_order.h"
#include "problems/gaussian_splatting/train/check_training.h"
#include "problems/gaussian_splatting/train/counted_work.h"
#include "problems/gaussian_splatting/train/fit_to_scene.h"
#include "problems/gaussian_splatting/train/joint_lm_stage.h"
#include "problems/gaussian_splatting/train/lm_stage.h"
#include "problems/gaussian_splatting/train/plan_stages.h"
#include "problems/gaussian_splatting/train/run_adam_stage.h"
#include "problems/gaussian_splatting/train/session.h"

namespace vesta::gs {
namespace {

constexpr double kMib = 1 << 20;

// What the store of photographs has yet to take.
double UnfilledMib(const Scene& scene) {
  if (!scene.photographs) return 0;
  return (scene.photographs->MostBytes() - scene.photographs->kept_bytes()) / kMib;
}

// Hands out Adam's result, where LM is to come.
void SaveBeforeLm(TrainingSession& session, const TrainCallbacks& callbacks, const SplatModel& model,
                  TrainResult* result) {
  const bool ends = session.early_end().stopped() || session.early_end().has_reached_target();
  if (callbacks.before_lm && session.options().lm.iterations > 0 && !ends) {
    try {
      callbacks.before_lm(model);
    } catch (const Error& error) {
      result->lm_left_out = error.what();
    }
  }
  if (session.together().OnAny(!result->lm_left_out.empty())) session.AdaptOptions().lm.iterations = 0;
}

void NoteMissedTarget(TrainingSession& session) {
  session.Note(
      fmt::format("{:.2f} dB on the views held out, not the {:.2f} of --target_psnr; give it longer, as by "
                  "--preset=best, or a lower target",
                  session.history().held_out_psnr(), session.options().target_psnr));
}

// All that the session has to tell.
void TakeFindings(TrainingSession& session, TrainResult* result) {
  result->eval_seconds = session.EvalSeconds();
  result->stopped = session.early_end().stopped();
  result->predictions = session.TakePredictions();
  if (session.early_end().misses_target() && !result->stopped) NoteMissedTarget(session);
  result->cameras = session.cameras().found();
  if (!result->cameras.empty()) {
    result->camera_changes =
        ChangesOf(result->model, session.cameras().given(), result->cameras, NearPlane(session.scene()));
  }
  result->history = session.history().Take();
  result->megapixels = CountedMegapixels(session.training_views(), session.options(), result->history);
  result->notes = session.TakeNotes();
}

TrainResult RunStages(const Scene& scene, SplatModel model, const TrainOptions& asked, bool is_given,
                      double seconds_before, const TrainCallbacks& callbacks, const StageRunners& stages) {
  CheckTraining(scene, asked, stages, callbacks.ranks);
  const double unfilled_mib = UnfilledMib(scene);  // before anything is taken from it
  TrainingSession session(scene, asked, seconds_before, callbacks);
  const TrainOptions& options = session.options();
  double& before_mib = session.AdaptOptions().memory.before_mib;
  before_mib = session.together().MostOfAll(before_mib + session.cameras().CopiedMib() + unfilled_mib);
  if (!stages.note.empty()) session.Note(stages.note);
  TrainResult result;
  const double begin = session.Seconds();
  if (session.saved().first_stage() == Stage::kLm && session.saved().state()) {
    model = session.saved().OrRefuse([&] { return ModelOfLmStage(*session.saved().state()); });
  }
  const double device_free = stages.device_memory ? stages.device_memory().free_bytes : 0;
  LimitGaussians(session, stages, model);
  TellWhatItIsFor(options, &model), model.origin = scene.origin;
  const Index trained = NumTrainingViews(scene);
  if (trained > options.evaluated_views) {
    session.Note(fmt::format("evaluations look at {} of {} training views; at more by train.evaluated_views",
                             options.evaluated_views, trained));
  }
  // The first row is of what was given, so that the gain can be told. Without Adam LM records that row.
  const bool tells_gain = is_given && options.adam.runs() && !callbacks.resume;
  if (tells_gain) session.history().Record(Stage::kLm, 0, ToKernelModel(model));
  if (options.adam.runs() && session.saved().first_stage() == Stage::kAdam) {
    stages.adam(session, model);
    SaveBeforeLm(session, callbacks, model, &result);
  }
  const double between = session.Seconds();
  session.cameras().DevelopAll();
  RunLm(session, stages, &model, &result);
  if (session.history().empty()) session.history().Record(Stage::kLm, 0, ToKernelModel(model));
  result.adam_seconds = between - begin;
  result.lm_seconds = session.Seconds() - between;
  result.memory.device_free_mib = device_free / kMib;
  if (stages.device_memory) result.memory.device_peak_mib = stages.device_memory().peak_bytes / kMib;
  result.model = std::move(model);
  TakeFindings(session, &result);
  return result;
}

}  // namespace

void TellWhatItIsFor(const TrainOptions& options, SplatModel* model) {
  for (std::size_t c = 0; c < 3; ++c) model->background[c] = static_cast<float>(options.background[c]);
  model->has_background = true;
  model->low_pass = options.low_pass;
}

const char* StageName(Stage stage) { return stage == Stage::kAdam ? "adam" : "lm"; }

StageRunners HostStages() {
  return {"cpu", RunAdamStage<CpuBackend<float>>, RunLmStage<CpuBackend<float>>, RunJointLmStage<CpuBackend<float>>};
}

TrainResult Train(const Scene& scene, const TrainOptions& options, double seconds_before,
                  const TrainCallbacks& callbacks, const StageRunners& stages) {
  const TrainOptions fitted = FitToScene(options, NumTrainingViews(scene));
  SplatModel model = InitializeFromPoints(scene.points, scene.extent, *fitted.sh_degree, fitted.density.max_gaussians);
  const std::vector<Index> order = SpatialOrder(model);
  model = InOrder(std::move(model), order);
  return RunStages(scene, std::move(model), fitted, false, seconds_before, callbacks, stages);
}

TrainResult Refine(const Scene& scene, SplatModel model, const TrainOptions& options, double seconds_before,
                   const TrainCallbacks& callbacks, const StageRunners& stages) {
  const std::vector<Index> order = SpatialOrder(model);
  const splat::ModelLayout layout = model;
  TrainOptions without_growth = FitToScene(options, NumTrainingViews(scene));
  without_growth.density.enabled = false;
  TrainResult result =
      RunStages(scene, InOrder(std::move(model), order), without_growth, true, seconds_before, callbacks, stages);
  // Some were taken out, or have a lower degree now: those left stay in the order of space.
  if (result.model.layout() != layout) return result;
  // Neither stage moves a Gaussian elsewhere among the others: theirs is the order they came in.
  std::vector<Index> back(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) back[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  result.model = InOrder(std::move(result.model), back);
  return result;
}

}  // namespace vesta::gs
