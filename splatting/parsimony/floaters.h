// SPDX-License-Identifier: Apache-2.0
// Floaters: Gaussians that belong to no surface, and hang before or around what a splat shows. None is wrong for sure;
// these are signs of it, all far from what the Gaussians of a surface are like.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/parsimony/judging_views.h"

namespace vesta::gs {

// The Gaussians that are left, ascending, and how many go for what; who has several reasons goes for the first.
struct FloaterCount {
  std::vector<Index> kept;
  // Of an opacity under 1/255, which is never drawn.
  Index faint = 0;
  // With a standard deviation longer than the model's median distance from its middle, and than its own: around all.
  Index huge = 0;
  // With no other nearer than ten times what is usual (the root of the mean squared distance to three, its median), nor
  // within reach of their falloff, six of their own longest standard deviations.
  Index isolated = 0;
  // Of which the views show hardly anything (Support::is_wanting).
  Index unsupported = 0;
};

// judges: may be null; none is unsupported then.
FloaterCount FindFloaters(const SplatModel& model, const JudgingViews* judges);

}  // namespace vesta::gs
