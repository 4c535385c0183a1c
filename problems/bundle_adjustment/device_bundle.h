// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment on a GPU. The whole Jacobian is stored. PCG solves for cameras and points together; its
// preconditioner is the diagonal blocks.
#pragma once

#include <memory>

#include "problems/bundle_adjustment/bal_file.h"
#include "solver/device_block_problem.h"
#include "solver/lm_options.h"

namespace vesta::bundle {

// x is as in BundleProblem. There is no robust loss.
std::unique_ptr<DeviceBlockProblem<double>> MakeDeviceBundleProblem(const BundleData& data);

// Solver options without elimination of the points.
LmOptions DeviceBundleLmOptions();

}  // namespace vesta::bundle
