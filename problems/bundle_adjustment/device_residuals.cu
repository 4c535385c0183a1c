// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/device_residuals.h"
#include "solver/device_functors.cuh"

namespace vesta::bundle {

std::unique_ptr<DeviceResiduals<double>> MakeDeviceResiduals(const std::vector<BundleObservation>& observations) {
  return std::make_unique<FunctorsOnDevice<BundleObservation, double>>(observations);
}

}  // namespace vesta::bundle
