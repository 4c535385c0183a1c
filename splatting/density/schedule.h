// When density control does what in the course of the Adam stage. The same on every device.
#pragma once

#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/density/options.h"

namespace vesta::gs {

// Whether the pulls of the iteration's views are of use.
inline bool Observes(const DensityOptions& density, const StageSpan& span) {
  return density.enabled && span.IsWithin(density.end);
}
// Whether clone, split and prune follow it.
inline bool Densifies(const DensityOptions& density, const StageSpan& span) {
  return Observes(density, span) && span.Reaches(density.every) && span.HasReached(density.begin);
}
inline bool ResetsOpacity(const DensityOptions& density, const StageSpan& span) {
  return span.Reaches(density.opacity_reset_every);
}

}  // namespace vesta::gs
