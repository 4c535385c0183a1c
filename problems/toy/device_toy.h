// SPDX-License-Identifier: Apache-2.0
// Curve fitting on a GPU: an example of a device problem (solver/device_functors.cuh).
#pragma once

#include <memory>
#include <vector>

#include "problems/toy/toy_problems.h"
#include "solver/device_block_problem.h"

namespace vesta {

// Residuals of the curve fit for DeviceBlockProblem. All samples depend on the same two parameters.
std::unique_ptr<DeviceResiduals<double>> MakeDeviceResiduals(const std::vector<ExponentialFit>& samples);

}  // namespace vesta
