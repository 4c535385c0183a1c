#include "problems/gaussian_splatting/train/check_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/view_owners.h"
#include "problems/gaussian_splatting/train/fit_to_scene.h"
#include "problems/gaussian_splatting/train/over_ranks.h"

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

// Of the photographs of these training views, where they are in a store.
double StoredBytes(const Scene& scene, const Share& own) {
  double bytes = 0;
  Index place = 0;  // among the training views
  for (const View& view : scene.views) {
    if (!view.is_trained()) continue;
    if (view.stored && place >= own.begin && place < own.end) bytes += view.stored->bytes();
    ++place;
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
  const Index views = NumTrainingViews(scene);
  const double budget = scene.photographs->budget_bytes();
  if (options.lm.iterations > 0 && !is_on_device && StoredBytes(scene, OwnTrainingViews(ranks, views)) > budget) {
    refuse(fmt::format("lm.iterations={}: Levenberg-Marquardt", options.lm.iterations));
  }
  const CameraChoice refined = options.cameras.refine;
  if (FreeBy(refined).color && StoredBytes(scene, OwnViewsInAdam(options, ranks, views)) > budget) {
    refuse(fmt::format("cameras.refine={}: to find exposures (cameras.refine=pose does not)",
                       schema::NameOf(refined, kCameraChoices)));
  }
}

// A splat is rendered with one filter, that of its scene's cameras.
void CheckLowPass(const Scene& scene, const TrainOptions& options) {
  for (const View& view : scene.views) {
    if (view.camera.low_pass == options.low_pass) continue;
    Fail("train.low_pass={}: the camera of view {} has {}; load the scene with LoadSceneOptions::low_pass",
         options.low_pass, view.name, view.camera.low_pass);
  }
}

void CheckTarget(const Scene& scene, const TrainOptions& options) {
  const auto is_held_out = [](const View& view) { return view.role == ViewRole::kHeldOut; };
  if (options.target_psnr <= 0 || std::ranges::any_of(scene.views, is_held_out)) return;
  Fail("train.target_psnr={}: the scene has no views held out to judge by; load it with LoadSceneOptions::hold_out",
       options.target_psnr);
}

// What cannot be found of cameras.
void CheckCameras(const Scene& scene, const TrainOptions& options, const Ranks* ranks) {
  const CameraChoice refined = options.cameras.refine;
  if (!options.cameras.refines()) return;
  const char* const name = schema::NameOf(refined, kCameraChoices);
  if (ranks && ranks->size() > 1) {
    Fail("--refine_cameras={}: one process finds cameras, not {}; start one, or choose none", name, ranks->size());
  }
  if (FindsCamerasByLm(options) && (refined == CameraChoice::kAuto || refined == CameraChoice::kAll)) {
    Fail("--refine_cameras={}: LM {}; choose pose, pose+exposure or none, or find them in an Adam stage", name,
         refined == CameraChoice::kAuto ? "decides nothing" : "finds no lenses");
  }
  if (!FreeBy(refined).lens) return;
  const auto bent = std::ranges::find_if(scene.views, [](const View& view) { return view.bent.has_value(); });
  if (bent == scene.views.end()) return;
  Fail(
      "--refine_cameras={}: the lens of view {} distorts, and no such one is found; choose pose+exposure, or undistort "
      "the photographs before",
      name, bent->name);
}

}  // namespace

void CheckTraining(const Scene& scene, const TrainOptions& options, const StageRunners& stages, Ranks* ranks) {
  CheckViews(scene);
  CheckLowPass(scene, options);
  CheckTarget(scene, options);
  CheckCameras(scene, options, ranks);
  CheckRanks(scene, options, stages, ranks);
  CheckStored(scene, options, ranks, stages.device_memory != nullptr);
}

}  // namespace vesta::gs
