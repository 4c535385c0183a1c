// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment on a GPU: the Jacobian of all observations is in the memory of the device; conjugate gradients run
// on cameras and points together, with their diagonal blocks as the preconditioner.
#pragma once

#include <memory>

#include "problems/bundle_adjustment/bal_file.h"
#include "solver/device_block_problem.h"
#include "solver/lm_options.h"

namespace vesta::bundle {

// x as in BundleProblem: the cameras, nine parameters each, then the points. Plain least squares.
std::unique_ptr<DeviceBlockProblem<double>> MakeDeviceBundleProblem(const BundleData& data);

// The options to solve it with: nothing is eliminated.
LmOptions DeviceBundleLmOptions();

}  // namespace vesta::bundle
