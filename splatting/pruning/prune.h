// SPDX-License-Identifier: Apache-2.0
// Which Gaussians go: by rank (Keepers) or by aic_weight (KeepByAic), in a training as well; and Prune, which takes
// them out of a finished model in rounds: what is worth little while others stand before or behind it may be worth much
// once they are gone, so all are judged anew after each.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {

// The `count` Gaussians of the model, at least one, without which the cost of the views would rise the most
// (scoring_views.h); ascending. supported: what hardly any view shows (Coverage::IsUnderObserved) goes before all
// others.
std::vector<Index> Keepers(const splat::Model<float>& model, const ScoringViews& judges, bool prune_unseen,
                           Index count);

// Those that pay for their parameters, ascending: without whom the cost of the views would rise by at least
// `aic_weight` times cost / n for each of them, n the number of the pixels' values. Price 1 is Akaike's criterion
// (1974, "A new look at the statistical model identification"), by which a parameter is let in where it raises the
// log-likelihood by more than one: with errors of Laplace's distribution, whose scale is their own mean, that of n of
// them is -n log(cost) and what does not depend on them.
//
// Two that stand in for each other are each worth little while both are there. So of those that do not pay only two
// fifths go at a time, by chance, and no more than a quarter of all. Each seed and round has others.
std::vector<Index> KeepByAic(const splat::Model<float>& model, const ScoringViews& judges, double aic_weight,
                             std::uint64_t seed, std::uint64_t round);

// Exactly one of the two is given.
struct PruneGoal {
  std::optional<Index> count;      // so many Gaussians stay, at least one; more than there are: all
  std::optional<double> max_rise;  // the cost of the training views rises by at most this part of itself, > 0
};

struct PruneOptions {
  PruneGoal goal;
  bool prune_unseen = true;  // what hardly any view shows goes before all others
};

struct PruneResult {
  SplatModel model;                        // those kept, in their order and as they were
  double cost_before = 0, cost_after = 0;  // of the training views (RemovalCost::cost)
  int rounds = 0;
};

// By the views that judge. Throws Error where none does.
PruneResult Prune(SplatModel model, const ScoringViews& judges, const PruneOptions& options);

}  // namespace vesta::gs
