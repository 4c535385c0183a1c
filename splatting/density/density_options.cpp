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
      {"enabled", &O::enabled, "clone, split and prune Gaussians during the Adam stage (densification)"},
      {"begin", &O::begin, kPart, "fraction of the Adam stage at which densification begins"},
      {"end", &O::end, kPart, "fraction of the Adam stage at which densification ends; at most pruning.begin"},
      {"every", &O::every, {1e-6, 1}, "fraction of the Adam stage between two densification steps"},
      {"grow_grad2d", &O::grow_grad2d, kSize,
       "clone or split Gaussians if the gradient of the loss by their image position (in half image sizes, as in "
       "3DGS), "
       "averaged over the views, exceeds X; larger: fewer Gaussians"},
      {"grow_scale3d", &O::grow_scale3d, kSize,
       "split such Gaussians if their largest standard deviation exceeds X scene extents, else clone them; the extent "
       "is "
       "half the median depth of the points"},
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
