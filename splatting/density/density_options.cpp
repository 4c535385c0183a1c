// SPDX-License-Identifier: Apache-2.0
#include "splatting/density/density_options.h"

namespace vesta::gs {

const schema::Table<DensityOptions>& DensityFields() {
  using O = DensityOptions;
  constexpr schema::Range kPart{0, 1}, kSize{0, 1e9};
  static const schema::Table<O> fields = {
      {"max_gaussians",
       &O::max_gaussians,
       {1, 1e8},
       "never more than N Gaussians, also at the start if the scene has more points",
       "max_gaussians"},
      {"enabled", &O::enabled, "split and prune Gaussians during the Adam stage (densification)"},
      {"begin", &O::begin, kPart, "fraction of the Adam stage at which densification begins"},
      {"end", &O::end, kPart, "fraction of the Adam stage at which densification ends; at most pruning.begin"},
      {"every", &O::every, {1e-6, 1}, "fraction of the Adam stage between two densification steps"},
      {"grow_pull", &O::grow_pull, kSize,
       "split a Gaussian if its pull (docs/glossary.md) exceeds X times the price of its 14 parameters by Akaike's "
       "criterion; larger: fewer Gaussians"},
      {"prune_opa", &O::prune_opa, kPart,
       "remove Gaussians with an opacity below this value at each densification step"},
      {"prune_scale3d", &O::prune_scale3d, kSize,
       "remove Gaussians whose largest standard deviation exceeds X scene extents; 0: no limit"},
      {"opacity_reset_every", &O::opacity_reset_every, kPart,
       "fraction of the Adam stage between two opacity resets; 0: no resets"},
  };
  return fields;
}

}  // namespace vesta::gs
