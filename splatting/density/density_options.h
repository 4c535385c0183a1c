// SPDX-License-Identifier: Apache-2.0
// Options of density control (split and prune), and its iterations.
#pragma once

#include "kernels/core/schema.h"
#include "kernels/core/span.h"
#include "problems/gaussian_splatting/scene/stage_span.h"

namespace vesta::gs {

// begin, end, every and opacity_reset_every are fractions of the Adam stage.
struct DensityOptions {
  bool enabled = true;
  double begin = 0.1;
  double end = 0.6;
  // Interval between two densifications. A longer training has equally many densifications, farther apart.
  double every = 0.05;
  double grow_pull = 50;     // a Gaussian is split if its pull exceeds this many prices (GaussianPrice)
  double prune_opa = 0.005;  // prune below this opacity
  double prune_scale3d = 0;  // prune above this largest standard deviation, in scene extents; 0: no limit
  // Interval at which all opacities are limited to 0.01, until `end`; 0: never.
  double opacity_reset_every = 0.0;
  Index max_gaussians = 500000;
};

const schema::Table<DensityOptions>& DensityFields();

// Whether the statistics include this iteration's views.
inline bool Observes(const DensityOptions& density, const StageSpan& span) {
  return density.enabled && span.IsWithin(density.end);
}
// Whether split and prune follow the iteration.
inline bool Densifies(const DensityOptions& density, const StageSpan& span) {
  return Observes(density, span) && span.CrossesMultipleOf(density.every) && span.HasReached(density.begin);
}
inline bool ResetsOpacity(const DensityOptions& density, const StageSpan& span) {
  return span.CrossesMultipleOf(density.opacity_reset_every);
}

}  // namespace vesta::gs
