// SPDX-License-Identifier: Apache-2.0
#include "problems/toy/device_toy.h"
#include "solver/device_functors.cuh"

namespace vesta {

std::unique_ptr<DeviceResiduals<double>> MakeDeviceResiduals(const std::vector<ExponentialFit>& samples) {
  return std::make_unique<FunctorsOnDevice<ExponentialFit, double>>(samples);
}

}  // namespace vesta
