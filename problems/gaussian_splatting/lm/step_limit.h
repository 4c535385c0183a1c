// How far a step may take each parameter of a Gaussian before its model is no longer trusted.
#pragma once

#include "kernels/core/span.h"

namespace vesta::gs {

enum class StepLimitKind {
  kNone,
  // `size` times a limit for each class of parameter: the mean one standard deviation (the largest), log-scales 1, the
  // quaternion 0.6 of its length, the opacity's logit 2, SH coefficients 0.6.
  kCaps,
  // No parameter alone may take the Gaussian further than a squared Hellinger distance of `size` from where it was, the
  // opacity being its mass (3DGS2-TR, arXiv 2602.00395, section 3; the bound on rotations is our own, see the source).
  kHellinger,
};

struct StepLimit {
  StepLimitKind kind = StepLimitKind::kNone;
  double size = 1;
};

// Clamps each entry of step at x (layout.h; both NumAttributes(sh_degree) * count entries) to its limit; entries of
// Gaussians whose limits are not finite stay. Returns whether any entry was clamped. Parallel.
template <class S>
bool LimitStep(const StepLimit& limit, Index count, int sh_degree, HostSpan<const S> x, HostSpan<S> step);

}  // namespace vesta::gs
