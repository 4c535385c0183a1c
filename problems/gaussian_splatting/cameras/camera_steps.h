// Steps of views' cameras and exposures while the splat is trained view by view: each time that a view is seen its own
// unknowns take a step by the gradient that is there anyway.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/cameras/options.h"
#include "problems/gaussian_splatting/cameras/view_unknowns.h"

namespace vesta::gs {

// Of one view, in the order of a step (FreeUnknowns); how steps are scaled.
struct CameraStepState {
  // Gauss-Newton's: J^T W J of the view's cost, square, when it was last measured; empty: not yet. age: of that.
  std::vector<double> curvature;
  int age = 0;
  // Adam's moments, and how many steps they are of.
  std::vector<double> first, second;
  int steps = 0;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(curvature, age, first, second, steps);
  }
};

// The step by a gradient of the view's cost; at most so far that the camera turns by `most` radians and moves by as
// much of `depth`. depth: world units.
std::vector<double> CameraStep(const CameraOptions& options, const FreeUnknowns& free,
                               const std::vector<double>& gradient, double depth, double most, CameraStepState* state);

}  // namespace vesta::gs
