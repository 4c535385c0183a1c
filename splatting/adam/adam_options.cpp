// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/adam_options.h"

namespace vesta::gs {
namespace {

constexpr schema::Choice<SecondMoment> kMetrics[] = {{SecondMoment::kBlock, "block"},
                                                     {SecondMoment::kDiagonal, "diagonal"}};
static_assert(schema::AreDistinct(kMetrics));

}  // namespace

const schema::Table<AdamOptions>& AdamFields() {
  using O = AdamOptions;
  constexpr schema::Range kPart{0, 1};
  static const schema::Table<O> fields = {
      {"iterations",
       &O::iterations,
       {0, 1e7},
       "length of the Adam stage in views processed (one per iteration, unless adam.batch_size is larger); auto: from "
       "the number of training views",
       "iterations"},
      {"iterations_scale", &O::iterations_scale, {1e-6, 1e6}, "factor on the number of iterations that auto chooses"},
      {"batch_size", &O::batch_size, {1, 1e6}, "views per Adam iteration; the number of iterations is divided by N"},
      {"second_moment", &O::second_moment, kMetrics,
       "second moments of Adam: an 11 x 11 matrix for the geometry of each Gaussian (better, slower per iteration), or "
       "one "
       "number per parameter as usual"},
      {"lr_scale", &O::lr_scale, {1e-6, 1e6}, "factor on all learning rates"},
      {"lr_final_ratio",
       &O::lr_final_ratio,
       {1e-6, 1},
       "learning rates at the end of the Adam stage, as a fraction of those at its start"},
      {"averaging_fraction", &O::averaging_fraction, kPart,
       "last fraction of the Adam stage, but only after the last densification, whose parameters are averaged to give "
       "the "
       "result (the latest count most); 0: no averaging"},
      {"half_resolution_until", &O::half_resolution_until, kPart,
       "fraction of the Adam stage that trains on images at half resolution"},
      {"sh_degree_interval", &O::sh_degree_interval, kPart,
       "fraction of the Adam stage after which the SH degree rises by one (twice that, if exposures are optimised); 0: "
       "all degrees from the start"},
      {"evaluations",
       &O::evaluations,
       {1, 1e7},
       "number of evaluations of training and test views during the Adam stage: rows of the history in metrics.json"},
  };
  return fields;
}

}  // namespace vesta::gs
