// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/adam_options.h"

namespace vesta::gs {
namespace {

constexpr schema::Choice<SecondMoment> kMetrics[] = {{SecondMoment::kBlock, "block"},
                                                     {SecondMoment::kDiagonal, "diagonal"}};
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
      {"iterations_scale", &O::iterations_scale, {1e-6, 1e6}, "factor on the iterations of auto"},
      {"batch_size",
       &O::batch_size,
       {1, 1e6},
       "views whose gradients make one iteration, of which there are then as many times fewer"},
      {"second_moment", &O::second_moment, kMetrics,
       "what scales the steps: all of a Gaussian's geometry, or each parameter alone"},
      {"lr_scale", &O::lr_scale, {1e-6, 1e6}, "factor on the learning rates"},
      {"lr_final_ratio", &O::lr_final_ratio, {1e-6, 1}, "part of them that is left at the end"},
      {"averaging_fraction", &O::averaging_fraction, kPart,
       "part, at its end, that shows and leaves mean parameters; 0: the last ones"},
      {"half_resolution_until", &O::half_resolution_until, kPart,
       "part, at its start, that sees images of half the size"},
      {"sh_degree_interval", &O::sh_degree_interval, kPart,
       "one more band of harmonics after each such part (twice it, with exposures); 0: all at once"},
      {"evaluations", &O::evaluations, {1, 1e7}, "rows of the history"},
  };
  return fields;
}

}  // namespace vesta::gs
