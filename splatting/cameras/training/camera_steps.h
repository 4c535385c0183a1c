// SPDX-License-Identifier: Apache-2.0
// Refinement of cameras, exposures and shared lenses during the Adam stage: the decision whether to refine, the
// schedule, and the steps.
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

// Fractions of the stage. Cameras begin to move at kCamerasMove: earlier, the rendered images do not show the scene
// yet. CameraChoice::kAuto is decided at kCamerasDecide, with the views that are held out until then.
inline constexpr double kCamerasMove = 0.01, kCamerasDecide = 0.1;
// The fraction of the stage until which the mean rotation of all cameras is fixed (SubtractMeanRotation). When the 2D
// dilation blurs Gaussians more than the photographs are blurred, it biases the mean rotation. With a smaller eps2d the
// rotation may therefore be free earlier (docs/decisions/mean-camera-rotation.md).
inline double MeanRotationFreeFrom(double eps2d) {
  constexpr double kSoonest = 0.45, kLater = 0.2;
  return kSoonest + kLater * std::min(eps2d / splat::kEps2d, 1.0);
}

// True for every eighth training view from the fourth on, at most eight in all.
inline bool IsHeldOutForDecision(std::size_t view, std::size_t views) {
  constexpr std::size_t kEvery = 8, kMost = 8, kFirst = 3;
  return view % std::max(kEvery, (views + kMost - 1) / kMost) == kFirst;
}

// The number of curvature measurements per view that are due by this iteration. A view is measured when cameras begin
// to move, each time the elapsed fraction has grown fourfold (the image becomes sharper), and at the change to
// full-size photographs.
inline int CurvatureAge(const AdamOptions& adam, const StageSpan& span) {
  int age = 1;
  for (double part = 4 * kCamerasMove; part < 1; part *= 4) age += span.HasReached(part) ? 1 : 0;
  return age + (IsCoarse(adam, span) ? 0 : 1);
}

// State of a view's camera steps. After each pass over the view, its own unknowns take a step along the gradient of its
// cost.
struct CameraStepState {
  // The latest measured J^T W J of the view's cost: square, in the order of a step (FreeUnknowns); empty before the
  // first measurement. age: measurements so far. pixels: size of the measured image; the cost is a sum over its pixels.
  std::vector<double> curvature;
  int age = 0;
  double pixels = 0;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(curvature, age, pixels);
  }
};

// Rescales a curvature measured at another image size to `pixels` pixels.
void RescaleCurvature(double pixels, CameraStepState* state);

// The scale of a camera's scene, its step limit, and the progress of the training.
struct CameraSurroundings {
  double depth = 1;  // depth of the scene in front of the camera, world units
  double most = 1;   // step limit: rotation in radians, translation in units of `depth`
  double done = 0;   // fraction of the stage
};

// The factor on the Gauss-Newton step. It is 1 until `done` = 0.8, then decreases geometrically to 0.1 at the end of
// the stage. Gradients are noisy while splats move. The decrease lets cameras converge together with the average of the
// splat.
double GaussNewtonPart(double done);

// The step of the view's own unknowns for a gradient of its cost; the lens part is zero (see LensStep). curvature:
// CameraStepState::curvature.
std::vector<double> CameraStep(const FreeUnknowns& free, const std::vector<double>& gradient,
                               const std::vector<double>& curvature, const CameraSurroundings& around);

// The accumulated system of one lens: Schur complement and gradient of the views seen so far, with the views' own
// unknowns eliminated, and the number of these views.
struct LensSystem {
  std::array<double, splat::kLensTangent * splat::kLensTangent> curvature{};
  std::array<double, splat::kLensTangent> gradient{};
  int views = 0;
};

// Adds one view to the system of its lens. gradient and curvature (CameraStepState) include the lens. The view's own
// unknowns are eliminated: for every value of the lens parameters they are assumed to be optimal.
void AddToLens(const FreeUnknowns& free, const std::vector<double>& gradient, const std::vector<double>& curvature,
               LensSystem* system);
// The lens step: `part` times the Gauss-Newton step, scaled so that no number exceeds `most`. A point at a distance of
// one focal length from the principal point then moves by at most `most` focal lengths. Zero if the system is empty.
splat::LensTangent LensStep(const LensSystem& system, double part, double most);
// The step with which a view's own unknowns follow a lens step; it includes the lens step. If the step of the view's
// own unknowns would not be finite, it is set to zero.
std::vector<double> Follow(const FreeUnknowns& free, const std::vector<double>& curvature,
                           const splat::LensTangent& lens);

// Evidence for refining the cameras of a scene: the improvement of held-out views when their cameras are fitted to the
// splat.
struct CameraEvidence {
  int views = 0;      // views that were fitted; 0: no evidence
  double pose = 0;    // median relative decrease of the loss when cameras are fitted
  double pixels = 0;  // median MedianShift of the fitted cameras
  // Relative decrease of the RMS error of the right halves when exposures are fitted on the left halves.
  double exposure = 0;

  // Poses or nothing. The threshold lies between the values for scenes with poses from bundle adjustment and for the
  // same scenes with perturbed cameras (docs/decisions/refine-cameras-auto.md). Exposures are never chosen, because
  // views of unknown exposure would then be rendered with the mean exposure. This is worse than the exposure of the
  // neighbouring views.
  CameraChoice Choice() const;
  std::string Words() const;
};

// views: views the splat was not trained on. background: 0..1. near: distance of the near plane, world units.
CameraEvidence EvidenceOf(const SplatModel& model, const std::vector<View>& views,
                          const std::array<double, 3>& background, double near);

}  // namespace vesta::gs
