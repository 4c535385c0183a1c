// SPDX-License-Identifier: Apache-2.0
// Options of finding cameras and exposures in the course of a training.
#pragma once

#include "kernels/core/schema.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// What of the training views' cameras is unknown.
enum class CameraChoice {
  kNone,
  kPose,
  kPoseAndExposure,
  kAll,   // lenses too, shared by the views of a camera: focal lengths and principal points
  kAuto,  // what views that are held out gain by (evidence.h)
};
inline constexpr schema::Choice<CameraChoice> kCameraChoices[] = {{CameraChoice::kNone, "none"},
                                                                  {CameraChoice::kPose, "pose"},
                                                                  {CameraChoice::kPoseAndExposure, "pose+exposure"},
                                                                  {CameraChoice::kAll, "all"},
                                                                  {CameraChoice::kAuto, "auto"}};
static_assert(schema::EachOnce(kCameraChoices));

struct CameraOptions {
  CameraChoice refine = CameraChoice::kNone;

  bool refines() const { return refine != CameraChoice::kNone; }
};

const schema::Table<CameraOptions>& CameraFields();

// What is free by that choice; of kAuto nothing, before it has chosen.
FreeUnknowns FreeBy(CameraChoice choice);

}  // namespace vesta::gs
