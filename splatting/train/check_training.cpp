// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/check_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/ranks/sum_over_ranks.h"
#include "splatting/distributed/splat_parts.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/settings/training_plan.h"

namespace vesta::gs {
namespace {

// One NaN or infinite pixel would spoil all Gaussians of its view.
void CheckPixels(const std::vector<View>& views) {
  std::vector<char> is_bad(views.size());
  ParallelFor(static_cast<Index>(views.size()), 1, [&](Index i) {
    const auto v = static_cast<std::size_t>(i);
    is_bad[v] = std::ranges::all_of(views[v].image.rgb, [](float value) { return std::isfinite(value); }) ? 0 : 1;
  });
  const auto bad = std::ranges::find(is_bad, 1);
  if (bad == is_bad.end()) return;
  Fail(kBadArgument, "view {}: a colour of its image is not finite; repair the image or remove the view",
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
      Fail(kBadArgument,
           "view {}: training needs its image with the camera's {} x {} pixels; load the scene with LoadScene",
           view.name, camera.width, camera.height);
    }
    has_training = has_training || view.is_trained();
  }
  if (!has_training) Fail(kBadArgument, "the scene has no training view: every 8th view is a test view");
  CheckPixels(scene.views);
}

// Stored photographs of all training views, bytes.
double StoredBytes(const Scene& scene) {
  double bytes = 0;
  for (const View& view : scene.views) {
    if (view.is_trained() && view.stored) bytes += view.stored->bytes();
  }
  return bytes;
}

// Rejects options that need all photographs in memory, or change them.
void CheckStored(const Scene& scene, const TrainOptions& options, bool is_on_device) {
  if (!scene.photographs) return;
  const auto refuse = [](const std::string& what) {
    Fail(kOutOfMemory,
         "{} needs all photographs in memory, but they do not fit; increase --photographs_mib, or use --downscale",
         what);
  };
  const bool have_room = StoredBytes(scene) <= scene.photographs->budget_bytes();
  if (options.lm.iterations > 0 && !is_on_device && !have_room) {
    refuse(fmt::format("lm.iterations={}: Levenberg-Marquardt", options.lm.iterations));
  }
  const CameraChoice refined = options.cameras.refine;
  if (FreeBy(refined).color && !have_room) {
    refuse(fmt::format("cameras.refine={}: exposure refinement (unlike cameras.refine=pose)",
                       schema::NameOf(refined, kCameraChoices)));
  }
}

// A splat is rendered with a single low-pass filter.
void CheckFilter(const Scene& scene, const TrainOptions& options) {
  for (const View& view : scene.views) {
    if (view.camera.eps2d != options.eps2d) {
      Fail(kBadArgument, "train.eps2d={}: the camera of view {} has {}; load the scene with LoadSceneOptions::eps2d",
           options.eps2d, view.name, view.camera.eps2d);
    }
    if (view.camera.antialiased != options.antialias) {
      Fail(kBadArgument,
           "train.antialias={}: the camera of view {} has {}; load the scene with LoadSceneOptions::antialiased",
           options.antialias, view.name, view.camera.antialiased);
    }
  }
}

void CheckTarget(const Scene& scene, const TrainOptions& options) {
  const auto is_held_out = [](const View& view) { return view.role == ViewRole::kHeldOut; };
  if (options.target_psnr <= 0 || std::ranges::any_of(scene.views, is_held_out)) return;
  Fail(kBadArgument, "train.target_psnr={}: the scene has no held-out views; load it with LoadSceneOptions::hold_out",
       options.target_psnr);
}

void CheckCameras(const Scene& scene, const TrainOptions& options, const ProcessGroup& processes) {
  const CameraChoice refined = options.cameras.refine;
  if (!options.cameras.refines()) return;
  const char* const name = schema::NameOf(refined, kCameraChoices);
  if (!processes.is_alone()) {
    Fail(kUnsupported,
         "--refine_cameras={}: only one process can refine cameras, not {}; start one process, or choose none", name,
         processes.ranks()->size());
  }
  if (FindsCamerasByLm(options) && (refined == CameraChoice::kAuto || refined == CameraChoice::kAll)) {
    Fail(kUnsupported,
         "--refine_cameras={}: LM {}; choose pose, pose+exposure or none, or refine cameras in an Adam stage", name,
         refined == CameraChoice::kAuto ? "does not support it" : "does not optimise lenses");
  }
  if (!FreeBy(refined).lens) return;
  const auto bent = std::ranges::find_if(scene.views, [](const View& view) { return view.bent.has_value(); });
  if (bent == scene.views.end()) return;
  Fail(kUnsupported,
       "--refine_cameras={}: the lens of view {} has distortion and cannot be refined; choose pose+exposure, or "
       "undistort the photographs first",
       name, bent->name);
}

// Collective.
void CheckProcesses(const Scene& scene, const TrainOptions& options, const StageRunners& stages,
                    const ProcessGroup& processes) {
  if (!processes.ranks()) return;
  if (options.lm.iterations > 0) {
    CheckOneBatch({options.lm.batches, options.lm.batch_size});
    CheckTerms(NumSplatParts(NumTrainingViews(scene)), *processes.ranks());
  }
  if (options.memory.budget_gib > 0) {
    Fail(kUnsupported,
         "--memory_budget={}: not supported under mpirun; start the training without mpirun, or omit the budget",
         options.memory.budget_gib);
  }
  if (processes.is_alone()) return;
  if (stages.device_memory)
    Fail(kUnsupported, "--device=cuda: several processes can train only on CPUs; use --device=cpu");
  if (scene.photographs) {
    Fail(kOutOfMemory,
         "each of several processes needs all photographs in memory, but they do not fit; start fewer processes, "
         "increase --photographs_mib, or use --downscale");
  }
  const std::vector<std::uint64_t> scenes = processes.Gather(std::vector<std::uint64_t>{FingerprintOf(scene)});
  for (std::size_t r = 1; r < scenes.size(); ++r) {
    if (scenes[r] != scenes[0])
      Fail(kBadArgument, "process {} has another scene than process 0; pass the same scene to all", r);
  }
}

}  // namespace

void CheckTraining(const Scene& scene, const TrainOptions& options, const StageRunners& stages,
                   const ProcessGroup& processes) {
  CheckViews(scene);
  CheckFilter(scene, options);
  CheckTarget(scene, options);
  CheckCameras(scene, options, processes);
  CheckProcesses(scene, options, stages, processes);
  CheckStored(scene, options, stages.device_memory != nullptr);
}

}  // namespace vesta::gs
