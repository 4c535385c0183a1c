#include "bench/training_race/adam_schedules.h"

#include <algorithm>
#include <cmath>

namespace vesta::bench {

gs::TrainOptions AdamAlone(const gs::TrainOptions& ours, int iterations, double rate_factor) {
  gs::TrainOptions options = ours;
  options.lm.iterations = 0;
  options.adam.metric = "diagonal";
  options.adam.coarse_part = 0;
  options.adam.cooldown = 0.1;
  options.adam.average_part = 0;
  options.adam.iterations = iterations;
  options.adam.rate_factor = rate_factor;
  return options;
}

gs::TrainOptions LargeBatchAdam(const gs::TrainOptions& ours, int iterations, double rate_factor, int views) {
  gs::TrainOptions options = AdamAlone(ours, std::max(1, iterations / views), rate_factor * std::sqrt(views));
  options.adam.views_per_iteration = views;
  return options;
}

}  // namespace vesta::bench
