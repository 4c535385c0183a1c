// Options of finding cameras and exposures in the course of a training.
#pragma once

#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/cameras/view_unknowns.h"
#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

// What of the training views' cameras is unknown.
enum class CameraChoice {
  kNone,
  kPose,
  kPoseAndExposure,
  kAll,   // lenses too, shared by the views of a camera: focal lengths, principal points, radial distortion
  kAuto,  // what views that are held out gain by (evidence.h)
};
inline constexpr schema::Choice<CameraChoice> kCameraChoices[] = {{CameraChoice::kNone, "none"},
                                                                  {CameraChoice::kPose, "pose"},
                                                                  {CameraChoice::kPoseAndExposure, "pose+exposure"},
                                                                  {CameraChoice::kAll, "all"},
                                                                  {CameraChoice::kAuto, "auto"}};
static_assert(schema::EachOnce(kCameraChoices));

// How a view's unknowns are stepped where the view is seen.
enum class CameraRule {
  kGaussNewton,
  kAdam,  // as other trainers do it, for comparison
};
inline constexpr schema::Choice<CameraRule> kCameraRules[] = {{CameraRule::kGaussNewton, "gauss_newton"},
                                                              {CameraRule::kAdam, "adam"}};
static_assert(schema::EachOnce(kCameraRules));

// Times are parts of the Adam stage.
struct CameraOptions {
  CameraChoice refine = CameraChoice::kNone;
  CameraRule rule = CameraRule::kGaussNewton;
  // Part of Gauss-Newton's step that is taken. In the last part of the stage, this long, it falls geometrically to
  // step_at_end: while splats move gradients are noisy, and cameras come to rest as the mean of the splat does.
  double step = 1;
  // Part of a view's step before that is added to each (heavy ball; Polyak 1964): cameras that are far off arrive
  // sooner, and follow sooner what is wrong with the splat (docs/results/2026-11-25-cameras-in-training.md).
  double momentum = 0;
  double rest = 0.2;
  double step_at_end = 0.1;
  // Whether LM finds them too, at once with the splats (train/joint_lm_stage.h). Without an Adam stage it does so
  // anyway.
  bool joint = false;
  // Adam's rates at the start: of rotations in radians, of translations in parts of the depth of what cameras see.
  double adam_rotation = 1e-3;
  double adam_translation = 1e-3;

  bool refines() const { return refine != CameraChoice::kNone; }
};

const schema::Table<CameraOptions>& CameraFields();
// Throws Error where they do not agree with each other.
void CheckTogether(const CameraOptions& options);

// What is free by that choice; of kAuto nothing, before it has chosen.
FreeUnknowns FreeBy(CameraChoice choice);
// The same of that view: radial distortion is free where its photograph was of a lens that bends.
FreeUnknowns FreeBy(CameraChoice choice, const View& view);

}  // namespace vesta::gs
