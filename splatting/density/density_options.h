// SPDX-License-Identifier: Apache-2.0
// Options of density control, and when it acts.
#pragma once

#include "kernels/core/schema.h"
#include "kernels/core/span.h"
#include "problems/gaussian_splatting/scene/stage_span.h"

namespace vesta::gs {

// Clone, split and prune (Kerbl et al. 2023, section 5.2). begin, end and the intervals are fractions of the Adam
// stage.
struct DensityOptions {
  bool enabled = true;
  double begin = 0.1;
  double end = 0.6;
  // A fraction too, so that a longer training has more time for as many Gaussians, not more Gaussians.
  double every = 0.05;
  double grow_grad2d = 7e-4;   // mean norm of d loss / d mean in normalised device coordinates
  double grow_scale3d = 0.01;  // standard deviation, in scene extents: split above, clone below
  double prune_opa = 0.005;
  double prune_scale3d = 0;          // standard deviation, in scene extents; 0: no limit
  double opacity_reset_every = 0.0;  // 0: never
  Index max_gaussians = 500000;      // hard cap
};

const schema::Table<DensityOptions>& DensityFields();

// Whether the statistics of this iteration's views are used.
inline bool Observes(const DensityOptions& density, const StageSpan& span) {
  return density.enabled && span.IsWithin(density.end);
}
// Whether the iteration is followed by clone, split and prune.
inline bool Densifies(const DensityOptions& density, const StageSpan& span) {
  return Observes(density, span) && span.CrossesMultipleOf(density.every) && span.HasReached(density.begin);
}
inline bool ResetsOpacity(const DensityOptions& density, const StageSpan& span) {
  return span.CrossesMultipleOf(density.opacity_reset_every);
}

}  // namespace vesta::gs
