// SPDX-License-Identifier: Apache-2.0
// Curve fits on a GPU: an example of how to write a problem for it (solver/device_functors.cuh).
#pragma once

#include <memory>
#include <vector>

#include "problems/toy/toy_problems.h"
#include "solver/device_block_problem.h"

namespace vesta {

// Residuals of a fit, for DeviceBlockProblem; every functor reads the same two parameters.
std::unique_ptr<DeviceResiduals<double>> MakeDeviceResiduals(const std::vector<ExponentialFit>& samples);

}  // namespace vesta
