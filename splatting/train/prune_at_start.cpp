// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/prune_at_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "splatting/adam/adam_options.h"
#include "splatting/pruning/prune.h"

namespace vesta::gs {

std::string PruneAtStart(const Scene& scene, std::optional<double> max_loss, TrainOptions& options, SplatModel& model) {
  constexpr int kFewIterations = 20;
  const bool is_short = options.adam.iterations && NumIterations(options.adam) < kFewIterations;
  if (!max_loss && !is_short) return "";
  const Index before = model.count;
  PruneOptions prune{.goal = {}, .prune_unseen = options.pruning.shrink_unseen};
  if (max_loss) {
    prune.goal.max_rise = max_loss;
  } else {
    const double kept = std::floor(options.pruning.keep_fraction * static_cast<double>(before));
    prune.goal.count = std::max<Index>(1, static_cast<Index>(kept));
  }
  PruneResult result = Prune(std::move(model), TrainingViewsOf(scene, options.background), prune);
  model = std::move(result.model);
  options.pruning.keep_fraction = 1;
  return fmt::format("pruned from {} to {} Gaussians in {} rounds; training loss {:.3f} times its former value", before,
                     model.count, result.rounds, result.cost_after / result.cost_before);
}

}  // namespace vesta::gs
