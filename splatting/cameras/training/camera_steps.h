// SPDX-License-Identifier: Apache-2.0
// Refinement of cameras, exposures and shared lenses during the Adam stage: decision, schedule and steps.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/adam/adam_options.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Fractions of the Adam stage. Cameras move from kCamerasMove on, because earlier rendered images do not show the
// scene. With CameraChoice::kAuto, some training views are held out until kCamerasDecide; these views decide whether
// cameras are refined (EvidenceOf).
inline constexpr double kCamerasMove = 0.01, kCamerasDecide = 0.1;
// Fraction of the stage until which the mean rotation of all cameras is fixed (SubtractMeanRotation). A 2D dilation
// above the photographs' own blur biases the mean rotation. So with a smaller eps2d the mean rotation is free earlier
// (docs/decisions/mean-camera-rotation.md).
inline double MeanRotationFreeFrom(double eps2d) {
  constexpr double kSoonest = 0.45, kLater = 0.2;
  return kSoonest + kLater * std::min(eps2d / splat::kEps2d, 1.0);
}

// Whether training view number `view` of `views` is held out to decide kAuto: every eighth from the fourth on, or
// fewer, so that they are at most eight.
inline bool IsHeldOutForDecision(std::size_t view, std::size_t views) {
  constexpr std::size_t kEvery = 8, kMost = 8, kFirst = 3;
  return view % std::max(kEvery, (views + kMost - 1) / kMost) == kFirst;
}

// Number of measurements of each view's curvature by this iteration. They are due when cameras begin to move, each time
// the elapsed fraction has grown fourfold (images become sharper), and at the change to full-size photographs.
inline int CurvatureAge(const AdamOptions& adam, const StageSpan& span) {
  int age = 1;
  for (double part = 4 * kCamerasMove; part < 1; part *= 4) age += span.HasReached(part) ? 1 : 0;
  return age + (IsCoarse(adam, span) ? 0 : 1);
}

// State of a view's camera steps. Each time Adam has processed the view, its own unknowns take a Gauss-Newton step from
// the gradient of its cost and a stored curvature.
struct CameraStepState {
  // curvature: the latest J^T W J of the view's cost; square, row-major, in the order of a step (FreeUnknowns); empty
  // before the first measurement. age: CurvatureAge at the last attempt to measure. pixels: number of pixels of the
  // measured image, since the cost is a sum over pixels.
  std::vector<double> curvature;
  int age = 0;
  double pixels = 0;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(curvature, age, pixels);
  }
};

void RescaleCurvature(double pixels, CameraStepState* state);

// Depth of a camera's scene, step limit of the camera, and progress of the training.
struct CameraStepContext {
  double depth = 1;  // depth of the scene in front of the camera, world units
  double most = 1;   // step limit: rotation in radians, translation in units of `depth`
  double done = 0;   // fraction of the stage
};

// Factor on the Gauss-Newton step: 1 until the fraction `done` of the stage is 0.8, then falling geometrically to 0.1
// at the end. Gradients are noisy while the Gaussians move; shorter steps let the cameras converge.
double GaussNewtonFactor(double done);

// The step of the view's pose and exposure; the lens part is zero (see LensStep). gradient: of the view's cost.
// curvature: CameraStepState::curvature.
std::vector<double> CameraStep(const FreeUnknowns& free, const std::vector<double>& gradient,
                               const std::vector<double>& curvature, const CameraStepContext& around);

// The 4 x 4 linear system for a step of one lens, summed over the views since the last step: Schur complement without
// the views' own unknowns (row-major), gradient, and number of views.
struct LensSystem {
  std::array<double, splat::kLensTangent * splat::kLensTangent> curvature{};
  std::array<double, splat::kLensTangent> gradient{};
  int views = 0;
};

// Adds one view to the system of its lens. gradient and curvature (CameraStepState) include the lens. Eliminates the
// view's own unknowns: they are optimal for every value of the lens parameters.
void AddToLens(const FreeUnknowns& free, const std::vector<double>& gradient, const std::vector<double>& curvature,
               LensSystem* system);
// `part` times the Gauss-Newton step, scaled so that no number exceeds `most`: a point one focal length from the
// principal point moves by at most `most` focal lengths. Zero if the system is empty.
splat::LensTangent LensStep(const LensSystem& system, double part, double most);
// The whole step of a view for a given lens step. The view's own unknowns change so that its quadratic model is minimal
// again. If the change is not finite, it is zero. curvature: CameraStepState::curvature.
std::vector<double> FollowLensStep(const FreeUnknowns& free, const std::vector<double>& curvature,
                                   const splat::LensTangent& lens);

// Evidence for refining the cameras of a scene: how much held-out views improve when their cameras are fitted.
struct CameraEvidence {
  int views = 0;      // fitted views; 0: no evidence
  double pose = 0;    // median relative decrease of the loss
  double pixels = 0;  // median MedianShift of the fitted cameras
  // Relative decrease of the RMS error of the right image halves if exposures are fitted to the left halves.
  double exposure = 0;

  // kPose if `pose` reaches a threshold, else kNone. The threshold lies between the values for scenes with poses from
  // bundle adjustment and for the same scenes with perturbed cameras (docs/decisions/refine-cameras-auto.md). Exposures
  // are never chosen: new views would get the mean exposure, which is worse than the exposure of neighbouring views.
  CameraChoice Choice() const;
  // Text for a note to the user.
  std::string Summary() const;
};

// Fits the cameras of `views`, on which the splat was not trained. background: 0..1. near: distance of the near plane,
// world units.
CameraEvidence EvidenceOf(const SplatModel& model, const std::vector<View>& views,
                          const std::array<double, 3>& background, double near);

}  // namespace vesta::gs
