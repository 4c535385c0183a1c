// SPDX-License-Identifier: Apache-2.0
// Selects Gaussians to prune, by ranking (Keepers) or by Akaike's criterion (KeepByAic); training uses both. Prune
// removes Gaussians from a finished model in rounds. Removing a Gaussian can raise the removal cost of its neighbours,
// so each round measures all costs again.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {

// The `count` Gaussians with the highest removal cost (scoring_views.h), ascending; at least one. prune_unseen:
// under-observed Gaussians (Coverage::IsUnderObserved) are removed before all others.
std::vector<Index> Keepers(const splat::Model<float>& model, const ScoringViews& judges, bool prune_unseen,
                           Index count);

// The Gaussians that pay for their parameters, in ascending order. A Gaussian pays if its removal raises the loss of
// the views by at least `aic_weight` times loss / n per parameter; n is the number of pixel values. A weight of 1 is
// Akaike's criterion (1974, "A new look at the statistical model identification"), which accepts a parameter if it
// raises the log-likelihood by more than one. For n errors with a Laplace distribution, whose scale is their mean, the
// log-likelihood is -n log(loss) plus a constant.
//
// Two Gaussians that can replace each other both have a low removal cost. One round therefore removes only a random two
// fifths of the Gaussians that do not pay, and at most a quarter of all. The random choice depends on seed and round.
std::vector<Index> KeepByAic(const splat::Model<float>& model, const ScoringViews& judges, double aic_weight,
                             std::uint64_t seed, std::uint64_t round);

// Exactly one of the two must be set.
struct PruneGoal {
  std::optional<Index> count;  // number of Gaussians to keep, at least one; values above the present number keep all
  std::optional<double> max_rise;  // maximum rise of the training loss, as a fraction of it, > 0
};

struct PruneOptions {
  PruneGoal goal;
  bool prune_unseen = true;  // under-observed Gaussians are removed first
};

struct PruneResult {
  SplatModel model;                        // the kept Gaussians, unchanged and in their order
  double cost_before = 0, cost_after = 0;  // training loss (RemovalCost::cost)
  int rounds = 0;
};

// Prunes with the given scoring views. Throws Error without any.
PruneResult Prune(SplatModel model, const ScoringViews& judges, const PruneOptions& options);

}  // namespace vesta::gs
