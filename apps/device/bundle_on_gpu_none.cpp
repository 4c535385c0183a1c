// SPDX-License-Identifier: Apache-2.0
// Builds without CUDA.
#include "apps/device/bundle_on_gpu.h"
#include "kernels/core/check.h"

namespace vesta::app {

LmSummary SolveBundleOnGpu(bundle::BundleData& /*data*/, const LmOptionsEdit& /*edit*/,
                           const LmCallback& /*callback*/) {
  Fail(kUnavailable, "--device=cuda: this build has no CUDA; use --device=cpu");
}

}  // namespace vesta::app
