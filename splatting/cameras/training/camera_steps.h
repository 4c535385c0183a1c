// SPDX-License-Identifier: Apache-2.0
// Steps of views' cameras and exposures while the splat is trained view by view: each time that a view is seen its own
// unknowns take a step by the gradient that is there anyway.
#pragma once

#include <vector>

#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Of one view: how steps are scaled.
struct CameraStepState {
  // J^T W J of the view's cost, square, in the order of a step (FreeUnknowns), when it was last measured; empty: not
  // yet. age: of that; pixels: of the image whose cost it is of, which is a sum over them.
  std::vector<double> curvature;
  int age = 0;
  double pixels = 0;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(curvature, age, pixels);
  }
};

// A curvature of the view at another size as that at this one.
void BringToSize(double pixels, CameraStepState* state);

// Where a camera is in its scene and its training.
struct CameraSurroundings {
  double depth = 1;  // of what it sees, world units
  double most = 1;   // a step turns it by at most so many radians, and moves it by as much of `depth`
  double done = 0;   // part of the stage
};

// Part of Gauss-Newton's step that is taken so far into the stage: the whole, and in the last fifth of the stage
// geometrically less, down to a tenth. While splats move gradients are noisy, and cameras come to rest as the mean of
// the splat does.
double GaussNewtonPart(double done);

// The step by a gradient of the view's cost, of what is the view's own: the lens stays (lens_steps.h). curvature: as
// CameraStepState has it.
std::vector<double> CameraStep(const FreeUnknowns& free, const std::vector<double>& gradient,
                               const std::vector<double>& curvature, const CameraSurroundings& around);

}  // namespace vesta::gs
