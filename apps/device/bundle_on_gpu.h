// SPDX-License-Identifier: Apache-2.0
// bundle_adjust on a GPU. bundle_on_gpu_none.cpp or bundle_on_gpu_cuda.cpp, as the build has CUDA or not.
#pragma once

#include <functional>

#include "problems/bundle_adjustment/bal_file.h"
#include "solver/lm_options.h"

namespace vesta::app {

// Changes the engine's options.
using LmOptionsEdit = std::function<void(LmOptions&)>;

// Plain least squares from data.x, in place, by the options for a GPU after `edit`. Throws Error, one line, where the
// GPU has no room; data are as they were then. Only where there is a GPU (apps/device/device.h).
LmSummary SolveBundleOnGpu(bundle::BundleData& data, const LmOptionsEdit& edit, const LmCallback& callback);

}  // namespace vesta::app
