// SPDX-License-Identifier: Apache-2.0
// Selects Gaussians to prune, by ranking (SelectToKeep) or by Akaike's information criterion (KeepByAic); training uses
// one of them at intervals. Prune removes Gaussians from a finished model in rounds. Each round measures all costs
// again, because removals may raise the costs of neighbours.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {

// Indices, ascending, of the `count` Gaussians with the highest removal cost (scoring_views.h); at least one.
// prune_unseen: under-observed Gaussians (Coverage::IsUnderObserved) are removed first. Collective.
std::vector<Index> SelectToKeep(const splat::Model<float>& model, const ScoringViews& scoring_views, bool prune_unseen,
                                Index count);

// Per Gaussian, the rise of the loss in all views but the one where it rises most. This view alone cannot tell a
// surface from a floater in front of its camera. If the views hardly overlap, no other view could confirm a surface; so
// the largest rise is subtracted with the weight min(1, 2 s), where s is the fraction of the positive rises of all
// Gaussians that is outside of the largest ones.
std::vector<double> SupportedRises(const RemovalCost& removal);

// Indices, ascending, of the Gaussians to keep by Akaike's information criterion: removing one would raise the loss of
// the views (SupportedRises) by at least `aic_weight` * loss / n per parameter; n is the number of pixel values
// (RemovalCost::values). A weight of 1 is Akaike's rule (1974, "A new look at the statistical model identification"): a
// parameter is accepted if it raises the log-likelihood by more than one. For n errors with a Laplace distribution
// whose scale is their mean, the log-likelihood is -n log(loss) plus a constant. SH bands that are not active yet cost
// nothing.
//
// Two Gaussians that can replace each other both have a low removal cost, but only one should be removed. So one call
// removes only a random two fifths of the Gaussians that fail the criterion, and at most a quarter of all. The choice
// depends on seed and round. Collective.
std::vector<Index> KeepByAic(const splat::Model<float>& model, const ScoringViews& scoring_views, double aic_weight,
                             std::uint64_t seed, std::uint64_t round);

// Set exactly one of count and max_rise.
struct PruneGoal {
  std::optional<Index> count;  // number of Gaussians to keep, at least one; values above the present number keep all
  std::optional<double> max_rise;  // maximum rise of the training loss, as a fraction of its first value, > 0
};

struct PruneOptions {
  PruneGoal goal;
  bool prune_unseen = true;  // under-observed Gaussians first
};

struct PruneResult {
  SplatModel model;                        // the kept Gaussians in their order
  double cost_before = 0, cost_after = 0;  // training loss (RemovalCost::loss)
  int rounds = 0;
};

// Scores with scoring_views. Throws Error if that list is empty.
PruneResult Prune(SplatModel model, const ScoringViews& scoring_views, const PruneOptions& options);

}  // namespace vesta::gs
