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
       "most Gaussians; of more points so many are taken",
       "max_gaussians"},
      {"enabled", &O::enabled, "whether Gaussians are cloned, split and pruned"},
      {"begin", &O::begin, kPart, "part of the Adam stage after which that begins"},
      {"end", &O::end, kPart, "part of it after which that ends; at most pruning.begin"},
      {"every", &O::every, {1e-6, 1}, "part of it between two times"},
      {"grow_grad2d", &O::grow_grad2d, kSize, "image-space gradient above which a Gaussian is cloned or split"},
      {"grow_scale3d", &O::grow_scale3d, kSize, "standard deviation, in scene extents, above which it is split"},
      {"prune_opa", &O::prune_opa, kPart, "opacity below which it is taken out"},
      {"prune_scale3d", &O::prune_scale3d, kSize,
       "standard deviation, in scene extents, above which it is; 0: no limit"},
      {"opacity_reset_every", &O::opacity_reset_every, kPart, "part of the stage between resets of opacity; 0: none"},
  };
  return fields;
}

}  // namespace vesta::gs
