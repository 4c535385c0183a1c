// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/prune.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/random.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/pruning/coverage.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {
namespace {

// Sorts by increasing score; ties: the higher index first.
std::vector<Index> LeastFirst(const std::vector<double>& scores) {
  std::vector<Index> order(scores.size());
  std::iota(order.begin(), order.end(), Index{0});
  const auto score = [&](Index i) { return scores[static_cast<std::size_t>(i)]; };
  std::ranges::sort(order, [&](Index a, Index b) { return score(a) != score(b) ? score(a) < score(b) : a > b; });
  return order;
}

// Maximum fraction of the Gaussians removed per round.
constexpr double kPartOfRound = 0.25;

Index PartOf(Index count, double part) { return static_cast<Index>(std::ceil(part * static_cast<double>(count))); }

// Indices of the highest scores, ascending; at least one.
std::vector<Index> Highest(const std::vector<double>& scores, Index count) {
  std::vector<Index> order = LeastFirst(scores);
  order.erase(order.begin(), order.end() - std::clamp(count, Index{1}, static_cast<Index>(scores.size())));
  std::ranges::sort(order);
  return order;
}

// If prune_unseen, scores under-observed Gaussians below all others.
std::vector<double> WithCoverage(std::vector<double> scores, const splat::Model<float>& model,
                                 const ScoringViews& scoring_views, bool prune_unseen) {
  if (!prune_unseen) return scores;
  const std::vector<bool> under_observed = WhichAreUnderObserved(model, scoring_views);
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (under_observed[i]) scores[i] = -std::numeric_limits<double>::infinity();
  }
  return scores;
}

void PruneToCount(const ScoringViews& scoring_views, const PruneOptions& options, PruneResult& result) {
  const Index count = std::max<Index>(*options.goal.count, 1);
  for (; result.model.count > count; ++result.rounds) {
    const Index left = std::max(count, result.model.count - PartOf(result.model.count, kPartOfRound));
    const std::vector<Index> kept =
        SelectToKeep(ToKernelModel(result.model), scoring_views, options.prune_unseen, left);
    result.model = InOrder(std::move(result.model), kept);
  }
}

// How many Gaussians, in this order, can be removed while the sum of their rises stays within `budget`. Negative rises
// count as 0: removal costs are measured one Gaussian at a time and do not add up.
Index WithinBudget(const std::vector<Index>& order, const std::vector<double>& rise, Index most, double budget) {
  Index gone = 0;
  for (; gone < most; ++gone) {
    budget -= std::max(0.0, rise[static_cast<std::size_t>(order[static_cast<std::size_t>(gone)])]);
    if (budget < 0) break;
  }
  return gone;
}

// Each round spends a fraction of the remaining rise, as predicted. Removals together cost more, so a round that costs
// too much is undone, and rounds become smaller. removal: of the whole model.
void PruneToRise(const ScoringViews& scoring_views, const PruneOptions& options, RemovalCost removal,
                 PruneResult& result) {
  constexpr double kLeastRound = 0.002;
  const double most = result.cost_before * (1 + *options.goal.max_rise);
  SplatModel last = result.model;
  double part_of_rest = 0.5, part_of_round = kPartOfRound;
  while (part_of_round > kLeastRound) {
    const splat::Model<float> model = ToKernelModel(last);
    std::vector<Index> order = LeastFirst(WithCoverage(removal.rise, model, scoring_views, options.prune_unseen));
    const auto limit = std::min(PartOf(last.count, part_of_round), last.count - 1);
    const Index gone = WithinBudget(order, removal.rise, limit, part_of_rest * (most - removal.loss));
    if (gone < PartOf(last.count, kLeastRound)) break;
    order.erase(order.begin(), order.begin() + gone);
    std::ranges::sort(order);
    result.model = InOrder(last, order);
    ++result.rounds;
    RemovalCost after = MeasureRemovalCost(ToKernelModel(result.model), scoring_views);
    if (after.loss > most) {
      part_of_rest *= 0.5, part_of_round *= 0.5;
      continue;
    }
    removal = std::move(after);
    last = result.model;
  }
  result.model = std::move(last);
}

}  // namespace

std::vector<Index> SelectToKeep(const splat::Model<float>& model, const ScoringViews& scoring_views, bool prune_unseen,
                                Index count) {
  return Highest(WithCoverage(MeasureRemovalCost(model, scoring_views).rise, model, scoring_views, prune_unseen),
                 count);
}

std::vector<double> SupportedRises(const RemovalCost& removal) {
  double all = 0, outside = 0;
  for (std::size_t i = 0; i < removal.rise.size(); ++i) {
    all += std::max(0.0, removal.rise[i]);
    outside += std::max(0.0, removal.rise[i] - removal.largest_rise[i]);
  }
  const double weight = all > 0 ? std::min(1.0, 2 * outside / all) : 0;
  std::vector<double> rises = removal.rise;
  for (std::size_t i = 0; i < rises.size(); ++i) rises[i] -= weight * removal.largest_rise[i];
  return rises;
}

std::vector<Index> KeepByAic(const splat::Model<float>& model, const ScoringViews& scoring_views, double aic_weight,
                             std::uint64_t seed, std::uint64_t round) {
  constexpr double kPartOfPoor = 0.4;
  const RemovalCost removal = MeasureRemovalCost(model, scoring_views);
  const double unit = aic_weight * removal.loss / removal.values;
  std::vector<double> gain = SupportedRises(removal);
  Index going = 0;
  for (std::size_t i = 0; i < gain.size(); ++i) {
    const int degree = std::min(model.DegreeOf(static_cast<Index>(i)), model.active_sh_degree);
    gain[i] -= unit * splat::NumAttributes(degree);
    const bool goes = gain[i] < 0 && CounterRandom(seed, round, i).Uniform() < kPartOfPoor;
    if (!goes) gain[i] = std::numeric_limits<double>::infinity();
    going += goes ? 1 : 0;
  }
  return Highest(gain, model.count - std::min(going, PartOf(model.count, kPartOfRound)));
}

PruneResult Prune(SplatModel model, const ScoringViews& scoring_views, const PruneOptions& options) {
  if (scoring_views.views.empty()) Fail(kBadArgument, "the scene has no training view to score Gaussians with");
  VESTA_CHECK(options.goal.count.has_value() != options.goal.max_rise.has_value(), "set exactly one goal");
  PruneResult result;
  result.model = std::move(model);
  RemovalCost removal = MeasureRemovalCost(ToKernelModel(result.model), scoring_views);
  result.cost_before = removal.loss;
  if (options.goal.count) {
    PruneToCount(scoring_views, options, result);
  } else {
    PruneToRise(scoring_views, options, std::move(removal), result);
  }
  result.cost_after = MeasureRemovalCost(ToKernelModel(result.model), scoring_views).loss;
  return result;
}

}  // namespace vesta::gs
