#include "bench/training_race/adam_schedules.h"

#include <fmt/format.h>

#include "bench/training_race/changes.h"

namespace vesta::bench {

gs::TrainOptions AdamAlone(const gs::TrainOptions& ours, int iterations, double rate_factor) {
  return Changed(ours, fmt::format("lm.iterations=0 adam.metric=diagonal adam.coarse_part=0 adam.cooldown=0.1 "
                                   "adam.average_part=0 adam.iterations={} adam.rate_factor={}",
                                   iterations, rate_factor));
}

gs::TrainOptions LargeBatchAdam(const gs::TrainOptions& ours, int iterations, double rate_factor, int views) {
  return Changed(AdamAlone(ours, iterations, rate_factor), fmt::format("adam.views_per_iteration={}", views));
}

}  // namespace vesta::bench
