// SPDX-License-Identifier: Apache-2.0
// Steps of lenses that views share while the splat is trained view by view: of some views that are seen the unknowns of
// their own are eliminated, what is left of their systems is summed, and solved.
#pragma once

#include <array>
#include <vector>

#include "splatting/cameras/training/camera_steps.h"

namespace vesta::gs {

// A lens's share of the systems of views: Schur complements, square, and gradients of them; of how many views.
struct LensSystem {
  std::array<double, splat::kLensTangent * splat::kLensTangent> curvature{};
  std::array<double, splat::kLensTangent> gradient{};
  int views = 0;
};

// Adds the view's, whose gradient and curvature (CameraStepState) are by all that is free, the lens included: with its
// own unknowns where they are best for every lens.
void AddToLens(const FreeUnknowns& free, const std::vector<double>& gradient, const std::vector<double>& curvature,
               LensSystem* system);
// The step of the lens by part of Gauss-Newton's. No number of it is larger than `most`: by so many focal lengths moves
// what is seen one from the principal point. Zero where nothing is known.
splat::LensTangent LensStep(const LensSystem& system, double part, double most);
// How a view's own unknowns follow such a step: a step of theirs, that of the lens included. They stay where that is no
// number.
std::vector<double> Follow(const FreeUnknowns& free, const std::vector<double>& curvature,
                           const splat::LensTangent& lens);

}  // namespace vesta::gs
