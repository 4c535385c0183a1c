// Options of density control.
#pragma once

#include "kernels/core/schema.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// Clone, split and prune (Kerbl et al. 2023, section 5.2). Times are parts of the Adam stage.
struct DensityOptions {
  bool enabled = true;
  double begin = 0.1;
  double end = 0.6;
  // As a part of the stage too: a longer training has more time for the same Gaussians, not more Gaussians.
  double every = 0.05;
  double gradient_threshold = 7e-4;  // mean norm of d loss / d mean in normalised device coordinates
  double split_above = 0.01;         // standard deviation, in scene extents: split above, clone below
  double prune_opacity = 0.005;
  double prune_size = 0;             // standard deviation, in scene extents; 0: no limit
  double opacity_reset_every = 0.0;  // 0: never
  Index max_gaussians = 500000;      // hard cap
};

const schema::Table<DensityOptions>& DensityFields();

}  // namespace vesta::gs
