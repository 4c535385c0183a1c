// SPDX-License-Identifier: Apache-2.0
// Cameras, exposures and shared lenses of views during the Adam stage: whether they are worth finding, when they move,
// and their steps.
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

// Parts of the stage: when cameras begin to move, since the first images are those of no splat yet; and when
// CameraChoice::kAuto is decided, by the views that are held back until then.
inline constexpr double kCamerasMove = 0.01, kCamerasDecide = 0.1;
// Until when the mean turn of all cameras is held (SubtractMeanRotation). Gaussians that are blurred by more than the
// photographs are, far ones as near ones, pull at it; so with a narrower filter it may move sooner
// (docs/decisions/mean-camera-rotation.md).
inline double MeanTurnFree(double eps2d) {
  constexpr double kSoonest = 0.45, kLater = 0.2;
  return kSoonest + kLater * std::min(eps2d / splat::kEps2d, 1.0);
}

// Every eighth training view from the fourth on is held back, but at most eight.
inline bool IsHeldBack(std::size_t view, std::size_t views) {
  constexpr std::size_t kEvery = 8, kMost = 8, kFirst = 3;
  return view % std::max(kEvery, (views + kMost - 1) / kMost) == kFirst;
}

// How often the curvature of a view should have been measured by the iteration: when cameras begin to move, whenever
// the stage is four times as long, since the image becomes sharper, and when photographs are seen at full size.
inline int CurvatureAge(const AdamOptions& adam, const StageSpan& span) {
  int age = 1;
  for (double part = 4 * kCamerasMove; part < 1; part *= 4) age += span.HasReached(part) ? 1 : 0;
  return age + (IsCoarse(adam, span) ? 0 : 1);
}

// Of one view: how steps are scaled. Each time that the view is seen, its own unknowns take a step by the gradient of
// its cost.
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

// The step by a gradient of the view's cost, of what is the view's own: the lens stays (LensStep). curvature: as
// CameraStepState has it.
std::vector<double> CameraStep(const FreeUnknowns& free, const std::vector<double>& gradient,
                               const std::vector<double>& curvature, const CameraSurroundings& around);

// A lens's share of the systems of some views that are seen, their own unknowns eliminated: Schur complements, square,
// and gradients of them; of how many views.
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

// Whether the cameras of a scene are worth finding along with its splat: what views that the splat has not seen gain by
// being fitted to it.
struct CameraEvidence {
  int views = 0;      // that were fitted; 0: nothing is known
  double pose = 0;    // part of their loss that goes when their cameras are fitted, median
  double pixels = 0;  // MedianShift that this takes, median
  // By how much smaller the error of their right halves is, as PSNR has it, with exposures of their left ones.
  double exposure = 0;

  // What it speaks for, poses or nothing. The bound lies between what scenes with poses by bundle adjustment say and
  // what the same say with cameras that are off (docs/decisions/refine-cameras-auto.md). Exposures are not
  // chosen: a view whose own is not known is rendered worse with the mean one than with its neighbours'.
  CameraChoice Choice() const;
  std::string Words() const;
};

// Views of which the splat knows nothing. background: 0..1. near: distance of the near plane, world units.
CameraEvidence EvidenceOf(const SplatModel& model, const std::vector<View>& views,
                          const std::array<double, 3>& background, double near);

}  // namespace vesta::gs
