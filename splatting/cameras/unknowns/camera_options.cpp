// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/unknowns/camera_options.h"

namespace vesta::gs {

const schema::Table<CameraOptions>& CameraFields() {
  using O = CameraOptions;
  static const schema::Table<O> fields = {
      {"refine", &O::refine, kCameraChoices,
       "what of the training views' cameras is found along with the splat; auto: what views held out gain by",
       "refine_cameras"},
  };
  return fields;
}

FreeUnknowns FreeBy(CameraChoice choice) {
  FreeUnknowns free;
  free.lens = choice == CameraChoice::kAll;
  free.color = free.lens || choice == CameraChoice::kPoseAndExposure;
  free.pose = free.color || choice == CameraChoice::kPose;
  return free;
}

}  // namespace vesta::gs
