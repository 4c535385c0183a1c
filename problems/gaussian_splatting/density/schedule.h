// When density control does what, in the iterations of the Adam stage. The same on every device.
#pragma once

#include <algorithm>

#include "problems/gaussian_splatting/density/options.h"

namespace vesta::gs {

// Clone, split and prune happen at iteration `it` of `n`.
inline bool DensifiesAt(const DensityOptions& density, int it, int n) {
  const int interval = std::max(1, static_cast<int>(density.every * n));
  return density.enabled && it % interval == 0 && it >= density.begin * n && it <= density.end * n;
}
inline bool ResetsOpacityAt(const DensityOptions& density, int it, int n) {
  const int every = static_cast<int>(density.opacity_reset_every * n);
  return every > 0 && it % every == 0;
}

}  // namespace vesta::gs
