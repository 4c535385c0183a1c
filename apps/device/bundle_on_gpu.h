// SPDX-License-Identifier: Apache-2.0
// bundle_adjust on a GPU. Implemented in bundle_on_gpu_cuda.cpp, or in bundle_on_gpu_none.cpp without CUDA.
#pragma once

#include <functional>

#include "problems/bundle_adjustment/bal_file.h"
#include "solver/lm_options.h"

namespace vesta::app {

// Changes the solver's options.
using LmOptionsEdit = std::function<void(LmOptions&)>;

// Minimises the sum of squares from data.x in place, with the default options for a GPU changed by `edit`. Throws Error
// (one line) if GPU memory is exhausted; data is then unchanged. Requires a GPU (CheckDevice).
LmSummary SolveBundleOnGpu(bundle::BundleData& data, const LmOptionsEdit& edit, const LmCallback& callback);

}  // namespace vesta::app
