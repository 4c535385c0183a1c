// SPDX-License-Identifier: Apache-2.0
// bundle_adjust on a GPU (bundle_on_gpu_cuda.cpp), or the error without CUDA (bundle_on_gpu_none.cpp).
#pragma once

#include <functional>

#include "problems/bundle_adjustment/bal_file.h"
#include "solver/lm_options.h"

namespace vesta::app {

// Changes the solver options in place.
using LmOptionsEdit = std::function<void(LmOptions&)>;

// Solves without a robust loss: data.x is the start and receives the solution. `edit` changes the default solver
// options for a GPU. `callback` is called after each iteration. Throws Error (one line) if GPU memory is exhausted;
// data is then unchanged. Needs a GPU: call CheckDevice first.
LmSummary SolveBundleOnGpu(bundle::BundleData& data, const LmOptionsEdit& edit, const LmCallback& callback);

}  // namespace vesta::app
