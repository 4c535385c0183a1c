// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment on a GPU. The Jacobian of all observations is in device memory. Conjugate gradients solve for
// cameras and points together, preconditioned by their diagonal blocks.
#pragma once

#include <memory>

#include "problems/bundle_adjustment/bal_file.h"
#include "solver/device_block_problem.h"
#include "solver/lm_options.h"

namespace vesta::bundle {

// x as in BundleProblem: nine parameters per camera, then three per point. Plain least squares.
std::unique_ptr<DeviceBlockProblem<double>> MakeDeviceBundleProblem(const BundleData& data);

// Solver options for it, without elimination.
LmOptions DeviceBundleLmOptions();

}  // namespace vesta::bundle
