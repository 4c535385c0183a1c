#include "problems/gaussian_splatting/cameras/options.h"

#include "kernels/core/check.h"

namespace vesta::gs {

const schema::Table<CameraOptions>& CameraFields() {
  using O = CameraOptions;
  static const schema::Table<O> fields = {
      {"refine", &O::refine, kCameraChoices,
       "what of the training views' cameras is found along with the splat; auto: what views held out gain by",
       "refine_cameras"},
      {"rule", &O::rule, kCameraRules, "how a camera is stepped when its view is trained on; adam: for comparison"},
      {"step", &O::step, {1e-6, 1.9}, "part of Gauss-Newton's step that is taken"},
      {"momentum", &O::momentum, {0, 0.99}, "part of the step before that is added to each"},
      {"rest", &O::rest, {0, 1}, "last part of the Adam stage, in which it falls"},
      {"step_at_end", &O::step_at_end, {1e-6, 1}, "the same at the end of the stage"},
      {"joint", &O::joint,
       "LM finds what is looked for of cameras at once with the splats; without an Adam stage it does anyway"},
      {"adam_rotation", &O::adam_rotation, {0, 1}, "Adam's rate of rotations, radians"},
      {"adam_translation", &O::adam_translation, {0, 1}, "Adam's rate of translations, parts of the depth"},
  };
  return fields;
}

void CheckTogether(const CameraOptions& options) {
  if (options.rule == CameraRule::kAdam && options.refine == CameraChoice::kAll) {
    Fail("cameras.rule=adam finds no lenses; choose cameras.refine=pose+exposure");
  }
}

FreeUnknowns FreeBy(CameraChoice choice) {
  FreeUnknowns free;
  free.lens = choice == CameraChoice::kAll;
  free.color = free.lens || choice == CameraChoice::kPoseAndExposure;
  free.pose = free.color || choice == CameraChoice::kPose;
  return free;
}

FreeUnknowns FreeBy(CameraChoice choice, const View& view) {
  FreeUnknowns free = FreeBy(choice);
  free.radial = free.lens && view.bent.has_value();
  return free;
}

}  // namespace vesta::gs
