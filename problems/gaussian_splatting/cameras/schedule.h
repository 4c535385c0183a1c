// When cameras are measured anew in the course of the Adam stage.
#pragma once

#include "problems/gaussian_splatting/adam/schedule.h"
#include "problems/gaussian_splatting/cameras/options.h"

namespace vesta::gs {

// How often the curvature of a view should have been measured by the iteration: when cameras begin to move, whenever
// the stage is four times as long, since the image becomes sharper, and when photographs are seen at full size.
inline int CurvatureAge(const CameraOptions& cameras, const AdamOptions& adam, const StageSpan& span) {
  int age = 1;
  for (double part = std::max(cameras.begin, 0.005); 4 * part < 1; part *= 4) age += span.HasReached(4 * part) ? 1 : 0;
  return age + (IsCoarse(adam, span) ? 0 : 1);
}

}  // namespace vesta::gs
