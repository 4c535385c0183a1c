// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/pruning_options.h"

#include "kernels/core/check.h"

namespace vesta::gs {

const schema::Table<PruningOptions>& PruningFields() {
  using O = PruningOptions;
  // After the last pruning, the model needs some iterations to recover.
  constexpr schema::Range kBeforeTheEnd{0, 0.99};
  static const schema::Table<O> fields = {
      {"unseen", &O::shrink_unseen,
       "shrink large Gaussians that hardly any training view shows, and Gaussians around a camera; with keep_fraction, "
       "remove those that hardly any view shows first"},
      {"aic_weight",
       &O::aic_weight,
       {0, 1e9},
       "before each densification, and from pruning.begin to pruning.end, remove Gaussians that lower the training "
       "loss too little for their number of parameters: by less than X times Akaike's criterion (AIC); larger: fewer "
       "Gaussians; 0: keep all"},
      {"sh_aic_weight",
       &O::sh_aic_weight,
       {0, 1e9},
       "the same for the SH coefficients above degree 0 of each Gaussian, which lowers its SH degree; larger: fewer "
       "coefficients; 0: keep all"},
      {"keep_fraction",
       &O::keep_fraction,
       {1e-9, 1},
       "Gaussians to keep, as a fraction of their number after densification; below 1 it replaces pruning.aic_weight; "
       "1: "
       "pruning.aic_weight decides",
       "keep"},
      {"begin", &O::begin, kBeforeTheEnd, "fraction of the Adam stage at which pruning begins; at least density.end"},
      {"end", &O::end, kBeforeTheEnd, "fraction of the Adam stage at which pruning ends"},
      {"every", &O::every, {1e-6, 1}, "fraction of the Adam stage between two pruning steps"},
  };
  return fields;
}

void ValidateCombination(const PruningOptions& pruning) {
  if (!pruning.prunes()) return;
  if (pruning.begin > pruning.end) {
    Fail(kBadArgument, "pruning.begin={} is after pruning.end={}: nothing would be pruned", pruning.begin, pruning.end);
  }
}

}  // namespace vesta::gs
