#include "problems/gaussian_splatting/train/trainer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/memory/memory_plan.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/spatial_order.h"
#include "problems/gaussian_splatting/model/view_owners.h"
#include "problems/gaussian_splatting/train/counted_work.h"
#include "problems/gaussian_splatting/train/fit_to_scene.h"
#include "problems/gaussian_splatting/train/lm_stage.h"
#include "problems/gaussian_splatting/train/over_ranks.h"
#include "problems/gaussian_splatting/train/run_adam_stage.h"
#include "problems/gaussian_splatting/train/session.h"

namespace vesta::gs {
namespace {

// A pixel that is no number would make all Gaussians of its view none.
void CheckPixels(const std::vector<View>& views) {
  std::vector<char> is_bad(views.size());
  ParallelFor(static_cast<Index>(views.size()), 1, [&](Index i) {
    const auto v = static_cast<std::size_t>(i);
    is_bad[v] = std::ranges::all_of(views[v].image.rgb, [](float value) { return std::isfinite(value); }) ? 0 : 1;
  });
  const auto bad = std::ranges::find(is_bad, 1);
  if (bad == is_bad.end()) return;
  Fail("view {}: a colour of its image is not a finite number; mend it or leave the view out",
       views[static_cast<std::size_t>(bad - is_bad.begin())].name);
}

void CheckViews(const Scene& scene) {
  bool has_training = false;
  for (const View& view : scene.views) {
    const Camera& camera = view.camera;
    const Image& image = view.image;
    const bool is_of_camera = image.width == camera.width && image.height == camera.height;
    const bool is_there = is_of_camera && !image.empty() && image.rgb.size() == 3 * image.num_pixels();
    if (!view.stored && !is_there) {
      Fail("view {}: training needs its image, of its camera's {} x {} pixels: LoadScene reads it", view.name,
           camera.width, camera.height);
    }
    has_training = has_training || view.is_trained();
  }
  if (!has_training) Fail("the scene has no training view: every 8th is held out for testing");
  CheckPixels(scene.views);
}

// Of the photographs of the training views that this process looks at.
double OwnBytes(const Scene& scene, const Ranks* ranks) {
  const std::vector<bool> is_own = OwnViewsOf(scene.views, ranks);
  double bytes = 0;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    if (is_own[v] && view.is_trained() && view.stored) bytes += view.stored->bytes();
  }
  return bytes;
}

// What needs all photographs at once, or changes them, which those in a store are not for.
void CheckStored(const Scene& scene, const TrainOptions& options, const Ranks* ranks, bool is_on_device) {
  if (!scene.photographs) return;
  const auto refuse = [](const std::string& what) {
    Fail(
        "{} needs all photographs in memory, which has no room for them; allow more by --photographs_mib, or use "
        "--downscale",
        what);
  };
  if (options.lm.iterations > 0 && !is_on_device && OwnBytes(scene, ranks) > scene.photographs->budget_bytes()) {
    refuse(fmt::format("lm.iterations={}: Levenberg-Marquardt", options.lm.iterations));
  }
  const CameraChoice refined = options.cameras.refine;
  if (options.cameras.refines() && refined != CameraChoice::kPose) {
    refuse(fmt::format("cameras.refine={}: to find exposures (cameras.refine=pose does not)",
                       schema::NameOf(refined, kCameraChoices)));
  }
}

// What the store of photographs has yet to take.
double UnfilledMib(const Scene& scene) {
  if (!scene.photographs) return 0;
  return (scene.photographs->MostBytes() - scene.photographs->kept_bytes()) / (1 << 20);
}

void CheckTarget(const Scene& scene, const TrainOptions& options) {
  const auto is_held_out = [](const View& view) { return view.role == ViewRole::kHeldOut; };
  if (options.target_psnr <= 0 || std::ranges::any_of(scene.views, is_held_out)) return;
  Fail("train.target_psnr={}: the scene has no views held out to judge by; load it with LoadSceneOptions::hold_out",
       options.target_psnr);
}

// What a model tells of itself beside its Gaussians.
void SetOrigins(const Scene& scene, const TrainOptions& options, SplatModel& model) {
  model.origin = scene.origin;
  for (std::size_t c = 0; c < 3; ++c) model.background[c] = static_cast<float>(options.background[c]);
  model.has_background = true;
}

// Hands out Adam's result, where LM is to come.
void SaveBeforeLm(const TrainingSession& session, const TrainCallbacks& callbacks, const SplatModel& model,
                  TrainOptions& options, TrainResult& result) {
  const bool ends = session.stopped() || session.has_reached_target();
  if (!callbacks.before_lm || options.lm.iterations == 0 || ends) return;
  try {
    callbacks.before_lm(model);
  } catch (const Error& error) {
    result.lm_left_out = error.what();
    options.lm.iterations = 0;
  }
}

// What of LM's options cannot be done, or does nothing.
void NoteOddities(const LmStageOptions& lm, Index batches, Index views, TrainingSession& session) {
  if (lm.iterations == 0) return;
  if (batches < lm.batches) {
    session.Note(fmt::format("LM in {} of the lm.batches={} asked for: there are {} training views", batches,
                             lm.batches, views));
  }
  if (lm.l1_weight == 0 && lm.ssim_weight == 0) {
    session.Note("LM has nothing to lower: lm.l1_weight and lm.ssim_weight are both 0");
  }
}

// Whether LM is left out, by one process for all.
bool IsLeftOutByAny(Ranks* ranks, const TrainResult& result) {
  const bool is_left_out = !result.lm_left_out.empty();
  return ranks ? OnAnyRank(*ranks, is_left_out) : is_left_out;
}

// LM as memory allows; what was foreseen and chosen goes into the result. options are those of the session.
void PlanAndRunLm(TrainingSession& session, TrainOptions& options, SplatModel& model, const StageRunners& stages,
                  TrainResult& result) {
  const std::vector<const View*>& views = session.training_views();
  const Index batches =
      ViewBatches::CutCount(options.lm.batches, options.lm.batch_size, static_cast<Index>(views.size()));
  NoteOddities(options.lm, batches, static_cast<Index>(views.size()), session);
  if (options.lm.iterations > 0 && options.lm.preconditioner == LmPreconditioner::kBlockSh && !model.is_uniform()) {
    options.lm.preconditioner = LmPreconditioner::kBlock;
    session.Note("LM with lm.preconditioner=block in place of block_sh: harmonics of different degrees have no blocks");
  }
  const bool has_cache = IsCached(options.lm.jacobian);
  const int some = stages.device_memory ? 8 : 4;
  const int counted = has_cache || options.memory.budget_gib > 0 ? static_cast<int>(views.size()) : some;
  const MemoryScene counts =
      CountMemory(ToKernelModel(model), session.planned_views(), NearPlane(session.scene()), counted, has_cache);
  LmPlan plan{options.lm};
  const StageMemory memory = MemoryToShare(stages, options.memory, session.ranks());
  try {
    plan = PlanLm(counts, options, memory);
    // A device always holds views where they fit, so that choice needs no note.
    const bool as_ever = stages.device_memory && options.lm.jacobian == JacobianKind::kRebuild &&
                         plan.lm.jacobian == JacobianKind::kRecompute;
    if (plan.lm.jacobian != options.lm.jacobian && !as_ever) {
      session.Note(fmt::format("LM with lm.jacobian={} in place of {}",
                               schema::NameOf(plan.lm.jacobian, kJacobianKinds),
                               schema::NameOf(options.lm.jacobian, kJacobianKinds)));
    }
  } catch (const Error& error) {
    // What Adam has made is not lost for want of memory.
    if (!options.adam.runs()) throw;
    result.lm_left_out = error.what();
    options.lm.iterations = 0;
  }
  if (IsLeftOutByAny(session.ranks(), result)) options.lm.iterations = 0;
  if (options.lm.iterations > 0 && !session.has_reached_target() && !session.ShouldStop()) {
    options.lm = plan.lm;
    result.lm_report = stages.lm(session, model, plan.hold_batches);
  } else {
    plan.bytes = 0;
  }
  session.NoteModel(model);
  const MemoryScene largest = counts.Of(session.largest_model());
  result.memory.jacobian = plan.lm.jacobian;
  result.memory.batches = static_cast<int>(batches);
  if (stages.device_memory) {
    result.memory.predicted_mib = PredictedMibBesideDevice(largest, options);
    result.memory.device_predicted_mib = PredictedDeviceMib(largest, options, plan.bytes, session.kept_on_device());
  } else {
    result.memory.predicted_mib = PredictedMib(largest, options, plan.bytes);
  }
}

void NoteMissedTarget(TrainingSession& session) {
  session.Note(
      fmt::format("{:.2f} dB on the views held out, not the {:.2f} of --target_psnr; give it longer, as by "
                  "--preset=best, or a lower target",
                  session.held_out_psnr(), session.options().target_psnr));
}

TrainResult RunStages(const Scene& scene, SplatModel model, TrainOptions options, bool is_given, double seconds_before,
                      const TrainCallbacks& callbacks, const StageRunners& stages) {
  CheckViews(scene);
  CheckTarget(scene, options);
  CheckRanks(scene, options, stages, callbacks.ranks);
  CheckStored(scene, options, callbacks.ranks, stages.device_memory != nullptr);
  TrainingSession session(scene, options, seconds_before, callbacks);
  options.memory.before_mib += session.cameras().CopiedMib() + UnfilledMib(scene);
  if (!stages.note.empty()) session.Note(stages.note);
  TrainResult result;
  const double begin = session.Seconds();
  if (session.first_stage() == Stage::kLm && session.saved_stage()) model = ModelOfLmStage(*session.saved_stage());
  const double device_free = stages.device_memory ? stages.device_memory().free_bytes : 0;
  if (options.memory.budget_gib > 0 || stages.device_memory) {
    const MemoryScene counts = CountMemory(ToKernelModel(model), session.planned_views(), NearPlane(scene), 8, false);
    const StageMemory memory = MemoryToShare(stages, options.memory, callbacks.ranks);
    const Index fit = PlanGaussians(counts, options, memory);
    if (stages.device_memory) {
      session.SetSpareDeviceBytes(memory.bytes - memory.adam_bytes(counts.Scaled(fit), options));
    }
    const bool grows = options.density.enabled && options.adam.runs();
    if (options.memory.budget_gib == 0 && grows && fit < options.density.max_gaussians) {
      session.Note(fmt::format("at most {} Gaussians: the GPU has no room for more", fit));
    }
    options.density.max_gaussians = fit;
  }
  SetOrigins(scene, options, model);
  // What it was shows what is gained. LM records where it starts itself.
  if (is_given && options.adam.runs()) session.Record(Stage::kLm, 0, ToKernelModel(model));
  if (options.adam.runs() && session.first_stage() == Stage::kAdam) {
    stages.adam(session, model);
    SaveBeforeLm(session, callbacks, model, options, result);
    if (IsLeftOutByAny(callbacks.ranks, result)) options.lm.iterations = 0;
  }
  const double between = session.Seconds();
  session.cameras().DevelopAll();
  PlanAndRunLm(session, options, model, stages, result);
  if (!session.has_history()) session.Record(Stage::kLm, 0, ToKernelModel(model));
  result.adam_seconds = between - begin;
  result.lm_seconds = session.Seconds() - between;
  result.eval_seconds = session.EvalSeconds();
  result.stopped = session.stopped();
  result.predictions = session.TakePredictions();
  if (options.target_psnr > 0 && !session.has_reached_target() && !result.stopped) NoteMissedTarget(session);
  result.model = std::move(model);
  result.cameras = session.cameras().found();
  if (!result.cameras.empty()) {
    result.camera_changes =
        ChangesOf(result.model, session.cameras().given(), result.cameras, NearPlane(session.scene()));
  }
  result.history = session.TakeHistory();
  result.megapixels = CountedMegapixels(session.training_views(), options, result.history);
  result.notes = session.TakeNotes();
  constexpr double kMib = 1 << 20;
  result.memory.device_free_mib = device_free / kMib;
  if (stages.device_memory) result.memory.device_peak_mib = stages.device_memory().peak_bytes / kMib;
  return result;
}

}  // namespace

const char* StageName(Stage stage) { return stage == Stage::kAdam ? "adam" : "lm"; }

StageRunners HostStages() { return {"cpu", RunAdamStage<CpuBackend<float>>, RunLmStage<CpuBackend<float>>}; }

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
