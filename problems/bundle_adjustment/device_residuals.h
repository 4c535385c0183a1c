// SPDX-License-Identifier: Apache-2.0
// Residuals of a bundle adjustment for DeviceBlockProblem.
#pragma once

#include <memory>
#include <vector>

#include "problems/bundle_adjustment/observation.h"
#include "solver/device_block_problem.h"

namespace vesta::bundle {

std::unique_ptr<DeviceResiduals<double>> MakeDeviceResiduals(const std::vector<BundleObservation>& observations);

}  // namespace vesta::bundle
