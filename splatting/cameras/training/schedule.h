// SPDX-License-Identifier: Apache-2.0
// What happens to cameras when, in the course of the Adam stage.
#pragma once

#include <algorithm>
#include <cstddef>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "splatting/adam/adam_options.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Parts of the stage: when cameras begin to move, since the first images are those of no splat yet; and when
// CameraChoice::kAuto is decided, by the views that are held back until then.
inline constexpr double kCamerasMove = 0.01, kCamerasDecide = 0.1;
// Until when the mean turn of all cameras is held (RemoveCommonTurn). Gaussians that are blurred by more than the
// photographs are, far ones as near ones, pull at it; so with a narrower filter it may move sooner
// (docs/results/2026-11-28-low-pass.md).
inline double MeanTurnFree(double low_pass) {
  constexpr double kSoonest = 0.45, kLater = 0.2;
  return kSoonest + kLater * std::min(low_pass / splat::kLowPass, 1.0);
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

}  // namespace vesta::gs
