// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/pruning_options.h"

#include "kernels/core/check.h"

namespace vesta::gs {

const schema::Table<PruningOptions>& PruningFields() {
  using O = PruningOptions;
  // After the last pruning, the model needs some iterations to recover.
  constexpr schema::Range kBeforeTheEnd{0, 0.99};
  static const schema::Table<O> fields = {
      {"unseen", &O::prune_unseen, "whether what hardly any training view shows is taken out"},
      {"aic_weight",
       &O::aic_weight,
       {0, 1e9},
       "what each parameter of a Gaussian must be removal, in parts of the cost by the pixels' values (1: Akaike)"},
      {"sh_aic_weight", &O::sh_aic_weight, {0, 1e9}, "the same for those of the higher degrees of its harmonics"},
      {"keep_fraction",
       &O::keep_fraction,
       {1e-9, 1},
       "part of the Gaussians that stays; of a training, of as many as they will become",
       "keep"},
      {"begin", &O::begin, kBeforeTheEnd,
       "part of the Adam stage after which the others begin to go; not before density.end"},
      {"end", &O::end, kBeforeTheEnd, "part of it after which all of them are gone"},
      {"every", &O::every, {1e-6, 1}, "part of it between two times"},
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
