// SPDX-License-Identifier: Apache-2.0
// Extreme Gaussians and cameras on the device, with the host's checks.
#include "tests/cuda/device_view.h"
#include "tests/kernels/gaussian_splatting/error_growth.h"

namespace vesta::test {
namespace {

class CudaExtremes : public OnDevice {};

void CheckAll(const std::vector<ExtremeScene>& cases) {
  for (const ExtremeScene& extreme : cases) {
    SCOPED_TRACE(extreme.name);
    CheckExtremeScene<DeviceRenderedView>(extreme);
  }
}

TEST_F(CudaExtremes, Gaussians) { CheckAll(ExtremeGaussians()); }
TEST_F(CudaExtremes, ErrorsGrowWithinTheirBounds) {
  for (const Growth& growth : Growths()) {
    SCOPED_TRACE(growth.name);
    CheckGrowth<DeviceRenderedView>(growth.scene);
  }
}

TEST_F(CudaExtremes, Cameras) { CheckAll(ExtremeCameras()); }

}  // namespace
}  // namespace vesta::test
