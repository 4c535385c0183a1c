// Trainings from cameras that are not where they are said to be: what each way of finding them along comes to.
//
//   cameras SCENE [--degrees 0.3] [--centre 0.01] [--exposure 0] [--focal 0] [--seeds 0] [--reports yes] [--json FILE]
//           [--methods none,gauss_newton,adam:1e-3:1e-3] [--joint_iterations 8] [--joint_pcg 4] [--rounds 4]
//           [--prior 0.01] -- [flags of vesta train]
//
// Each view is turned and shifted at random, those of test too, and training views are exposed so; all focal lengths
// are too long by --focal (perturbed_scene.h), and lenses are found where that is not 0.
// Methods: exact (nothing is perturbed, nothing found), settled (nothing is perturbed, gauss_newton all the same: where
// the splat takes right cameras), none, late (perturbed only after the Adam stage), gauss_newton, adam:R:T with these
// rates, auto. What comes after settled is measured beside where that ended, too: what is left of the perturbation.
// After a method, with a plus, what follows the Adam stage (endings.h; lm by default). PSNR of the test views, as
// stated and with their cameras (and exposures) fitted (cameras/aligned_evaluation.h).
#include <fmt/format.h>

#include <optional>
#include <string>
#include <vector>

#include "bench/cameras/endings.h"
#include "bench/cameras/gains.h"
#include "bench/cameras/perturbed_scene.h"
#include "bench/report.h"
#include "bench/training_race/setup.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/cameras/aligned_evaluation.h"
#include "problems/gaussian_splatting/cameras/moved_view.h"
#include "problems/gaussian_splatting/evaluate/renderer.h"
#include "problems/gaussian_splatting/model/to_kernel.h"
#include "problems/gaussian_splatting/train/training_cameras.h"

namespace vesta::bench {
namespace {

double Number(const Arguments& arguments, const char* flag, const char* fallback) {
  return std::stod(arguments.Flag(flag, fallback));
}

// What of cameras is off.
gs::CameraChoice WhatIsOff(const Perturbation& by) {
  if (by.focal != 0) return gs::CameraChoice::kAll;
  return by.exposure != 0 ? gs::CameraChoice::kPoseAndExposure : gs::CameraChoice::kPose;
}

// Sets what the method's name says.
void Choose(const std::string& method, const Perturbation& by, gs::CameraOptions* cameras) {
  const gs::CameraChoice free = WhatIsOff(by);
  if (method == "exact" || method == "none" || method == "late") {
    cameras->refine = gs::CameraChoice::kNone;
  } else if (method == "gauss_newton" || method == "settled") {
    cameras->refine = free;
  } else if (method == "auto") {
    cameras->refine = gs::CameraChoice::kAuto;
  } else if (method.starts_with("adam:")) {
    cameras->refine = free, cameras->rule = gs::CameraRule::kAdam;
    const std::size_t colon = method.find(':', 5);
    if (colon == std::string::npos) throw Error(method + ": the form is adam:ROTATION:TRANSLATION");
    cameras->adam_rotation = std::stod(method.substr(5, colon - 5));
    cameras->adam_translation = std::stod(method.substr(colon + 1));
  } else {
    throw Error(method + ": methods are exact, settled, none, late, gauss_newton, auto and adam:ROTATION:TRANSLATION");
  }
}

// Whether a method begins from the cameras of the scene.
bool IsUnperturbed(const std::string& method) { return method.starts_with("exact") || method.starts_with("settled"); }

// Whether an ending looks for what is off where no method says what is looked for; the others find poses.
bool FindsAll(Ending ending) { return ending == Ending::kJoint || ending == Ending::kReduced; }

gs::JointOptions JointOptionsOf(const gs::Scene& scene, const gs::TrainOptions& options, gs::CameraChoice off,
                                const Arguments& arguments) {
  gs::JointOptions joint;
  joint.free = gs::FreeBy(options.cameras.refines() ? options.cameras.refine : off);
  joint.lm = options.lm;
  joint.lm.min_gain = 0;
  joint.lm.pcg_iterations = arguments.Count("joint_pcg", 4);
  joint.iterations = arguments.Count("joint_iterations", 8);
  joint.rates = options.rates;
  joint.background = options.background;
  joint.near = gs::NearPlane(scene);
  joint.extent = scene.extent;
  joint.prior_weight = Number(arguments, "prior", "0.01");
  return joint;
}

// The latest training without an ending: several endings may follow it.
struct LatestTraining {
  std::string name;  // with its seed
  gs::TrainResult result;
};

// Trained on one scene and ended on the other, which differ in their cameras alone. products: RunEnding's.
gs::TrainResult TrainAndEnd(const std::string& name, const gs::Scene& trained, const gs::Scene& scene,
                            gs::TrainOptions options, Ending ending, gs::CameraChoice off, const Arguments& arguments,
                            LatestTraining* latest, int* products) {
  if (ending == Ending::kLm) {
    if (&trained != &scene)
      throw Error("late: what follows begins where the training has ended; choose another ending than lm");
    return gs::Train(trained, options, 0, {});
  }
  options.lm.iterations = 0;
  if (latest->name != name) *latest = {name, gs::Train(trained, options, 0, {})};
  gs::TrainResult result = latest->result;
  result.lm_seconds = 0;
  if (ending == Ending::kNothing) return result;
  std::vector<const gs::View*> views;
  for (const gs::View& view : scene.views) {
    if (view.is_trained()) views.push_back(&view);
  }
  Ended ended = RunEnding(ending, std::move(result.model), views, result.cameras,
                          {JointOptionsOf(scene, options, off, arguments), arguments.Count("rounds", 4)});
  result.model = std::move(ended.model);
  result.cameras = std::move(ended.views);
  result.lm_seconds = ended.seconds;
  result.lm_report = std::move(ended.report);
  *products = ended.products;
  return result;
}

// Where Gauss-Newton has taken the cameras of the scene.
struct Settled {
  gs::Scene scene;
  std::vector<double> gains;  // of the training views
};

int Main(int argc, char** argv) {
  const RaceSetup setup = SetUpRace(argc, argv,
                                    {"degrees", "centre", "exposure", "focal", "seeds", "methods", "json",
                                     "joint_iterations", "joint_pcg", "rounds", "prior", "reports"});
  const Arguments& arguments = setup.arguments;
  const Perturbation by{Number(arguments, "degrees", "0.3"), Number(arguments, "centre", "0.01"),
                        Number(arguments, "exposure", "0"), Number(arguments, "focal", "0")};
  SetNumThreads(setup.threads);
  Report report("cameras");
  LatestTraining latest;
  for (const std::string& seed : SplitAtCommas(arguments.Flag("seeds", "0"))) {
    std::vector<double> gains;
    const gs::Scene perturbed = Perturbed(setup.scene, by, std::stoull(seed), &gains);
    gains = OfTrainingViews(perturbed, gains);
    std::optional<Settled> settled;
    for (const std::string& method : SplitAtCommas(arguments.Flag("methods", "exact,none,gauss_newton"))) {
      const gs::Scene& scene = IsUnperturbed(method) ? setup.scene : perturbed;
      gs::TrainOptions options = setup.options;
      options.seed = std::stoull(seed);
      std::string training = method;
      const Ending ending = TakeEnding(&training);
      Choose(training, by, &options.cameras);
      int products = 0;
      std::string name = training;
      name.append(" ").append(seed);
      const gs::TrainResult result =
          TrainAndEnd(name, training == "late" ? setup.scene : scene, scene, options, ending,
                      FindsAll(ending) ? WhatIsOff(by) : gs::CameraChoice::kPose, arguments, &latest, &products);
      if (arguments.Flag("reports", "") == "yes") fmt::print("{}\n", result.lm_report);
      const std::vector<gs::View> views = gs::MovedViews(scene, result.cameras);
      std::vector<const gs::View*> found;
      for (const gs::View& view : views) {
        if (view.is_trained()) found.push_back(&view);
      }
      const PoseError error = ErrorOf(setup.scene, found);
      const std::vector<double> found_gains = GainsOf(scene, result.cameras);
      PoseError left;
      double left_gain = 0;
      if (settled) {
        left = ErrorOf(settled->scene, found);
        std::vector<double> both = gains;
        for (std::size_t i = 0; i < both.size(); ++i) both[i] *= settled->gains[i];
        left_gain = GainError(both, found_gains);
      }
      gs::AlignOptions align;
      align.near = gs::NearPlane(scene);
      align.levels = 5;
      gs::Scene judged = scene;  // test views through the lenses that were found
      for (std::size_t v = 0; v < views.size(); ++v) judged.views[v].camera = views[v].camera;
      const gs::AlignedEvaluation aligned = gs::EvaluateAligned(result.model, judged, align);
      align.free.color = true;
      const gs::AlignedEvaluation exposed = gs::EvaluateAligned(result.model, judged, align);
      // Test views as stated, training views as found.
      gs::TrainingCameras cameras(scene, {.refine = gs::CameraChoice::kAll});
      cameras.Restore(result.cameras);
      cameras.DevelopAll();
      const gs::Evaluation quality =
          gs::Renderer(options.background, gs::NearPlane(scene)).Evaluate(result.model, cameras.scene());
      report.Add({{"scene", setup.scene_name},
                  {"degrees", by.degrees},
                  {"centre", by.centre},
                  {"exposure", by.exposure},
                  {"focal", by.focal},
                  {"seed", seed},
                  {"method", method},
                  {"off_degrees", error.degrees},
                  {"off_pixels", error.pixels},
                  {"off_pixels_most", error.most},
                  {"off_pixels_near", error.near},
                  {"left_pixels", left.pixels},
                  {"left_pixels_near", left.near},
                  {"off_focal", std::abs(found[0]->camera.lens.fx / setup.scene.views[0].camera.lens.fx - 1)},
                  {"off_gain", GainError(IsUnperturbed(method) ? GainsOf(scene, {}) : gains, found_gains)},
                  {"left_gain", left_gain},
                  {"psnr", quality.test.psnr},
                  {"psnr_train", quality.train.psnr},
                  {"psnr_aligned", aligned.whole.psnr},
                  {"ssim_aligned", aligned.whole.ssim},
                  {"psnr_right", exposed.right.psnr},
                  {"psnr_right_exposed", exposed.right_exposed.psnr},
                  {"not_aligned", static_cast<double>(aligned.not_found)},
                  {"adam_seconds", result.adam_seconds},
                  {"end_seconds", result.lm_seconds},
                  {"cost", quality.cost},
                  {"end_products", static_cast<double>(products)}});
      if (method.starts_with("settled")) {
        settled = {setup.scene, found_gains};
        settled->scene.views = views;
      }
      for (const std::string& note : result.notes) fmt::print("{}: {}\n", method, note);
      report.WriteJson(arguments.Flag("json", ""));
    }
  }
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("cameras", vesta::bench::Main, argc, argv); }
