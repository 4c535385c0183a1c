// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment on a GPU, which stores the whole Jacobian. PCG solves for cameras and points together, with the
// diagonal blocks as preconditioner.
#pragma once

#include <memory>

#include "problems/bundle_adjustment/bal_file.h"
#include "solver/device_block_problem.h"
#include "solver/lm_options.h"

namespace vesta::bundle {

// x as in BundleProblem. Plain least squares.
std::unique_ptr<DeviceBlockProblem<double>> MakeDeviceBundleProblem(const BundleData& data);

// Solver options without elimination of the points.
LmOptions DeviceBundleLmOptions();

}  // namespace vesta::bundle
