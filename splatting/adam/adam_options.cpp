// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/adam_options.h"

namespace vesta::gs {
namespace {

constexpr schema::Choice<AdamMetric> kMetrics[] = {{AdamMetric::kBlock, "block"}, {AdamMetric::kDiagonal, "diagonal"}};
static_assert(schema::EachOnce(kMetrics));

}  // namespace

const schema::Table<AdamOptions>& AdamFields() {
  using O = AdamOptions;
  constexpr schema::Range kPart{0, 1};
  static const schema::Table<O> fields = {
      {"iterations",
       &O::iterations,
       {0, 1e7},
       "iterations of Adam, counted in views seen; auto: by the number of training views",
       "iterations"},
      {"length", &O::length, {1e-6, 1e6}, "factor on the iterations of auto"},
      {"views_per_iteration",
       &O::views_per_iteration,
       {1, 1e6},
       "views whose gradients make one iteration, of which there are then as many times fewer"},
      {"metric", &O::metric, kMetrics, "what scales the steps: all of a Gaussian's geometry, or each parameter alone"},
      {"rate_factor", &O::rate_factor, {1e-6, 1e6}, "factor on the learning rates"},
      {"rate_decay", &O::rate_decay, {1e-6, 1}, "part of them that is left at the end"},
      {"average_part", &O::average_part, kPart,
       "part, at its end, that shows and leaves mean parameters; 0: the last ones"},
      {"coarse_part", &O::coarse_part, kPart, "part, at its start, that sees images of half the size"},
      {"sh_band_every", &O::sh_band_every, kPart,
       "one more band of harmonics after each such part (twice it, with exposures); 0: all at once"},
      {"evaluations", &O::evaluations, {1, 1e7}, "rows of the history"},
  };
  return fields;
}

}  // namespace vesta::gs
