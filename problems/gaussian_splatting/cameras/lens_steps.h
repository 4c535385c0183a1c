// Steps of lenses that views share while the splat is trained view by view: of some views that are seen the unknowns of
// their own are eliminated, what is left of their systems is summed, and solved.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/cameras/camera_steps.h"

namespace vesta::gs {

// A lens's share of the systems of views: Schur complements, square, and gradients of them, of as many numbers as are
// free; of how many views.
struct LensSystem {
  std::array<double, kLensNumbers * kLensNumbers> curvature{};
  std::array<double, kLensNumbers> gradient{};
  std::array<double, kRadialTangent> before{};  // curvatures of k1 and k2 before views' own unknowns were eliminated
  int views = 0;
};

// Adds the view's, whose gradient and curvature (CameraStepState) are by all that is free, the lens included: with its
// own unknowns where they are best for every lens.
void AddToLens(const FreeUnknowns& free, const std::vector<double>& gradient, const std::vector<double>& curvature,
               LensSystem* system);
// How far a step of a lens may go, in focal lengths: by more than `most` no number of it moves what is seen one from
// the principal point, nor k1 and k2 what is seen `corner` from it, of all pixels the farthest.
struct LensLimit {
  double most = 1, corner = 1;
};
// The step of the lens, of whose views the same is free, by part of Gauss-Newton's. Zero where nothing is known.
LensStepNumbers LensStep(const FreeUnknowns& free, const LensSystem& system, double part, const LensLimit& limit);
// How a view's own unknowns follow such a step: a step of theirs, that of the lens included. They stay where that is no
// number.
std::vector<double> Follow(const FreeUnknowns& free, const std::vector<double>& curvature, const LensStepNumbers& lens);

}  // namespace vesta::gs
