// SPDX-License-Identifier: Apache-2.0
// Builds with CUDA.
#include "apps/device/bundle_on_gpu.h"
#include "kernels/core/check.h"
#include "kernels/core/cuda_backend.h"
#include "problems/bundle_adjustment/device_bundle.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::app {

LmSummary SolveBundleOnGpu(bundle::BundleData& data, const LmOptionsEdit& edit, const LmCallback& callback) {
  using B = CudaBackend<double>;
  LmOptions options = bundle::DeviceBundleLmOptions();
  edit(options);
  const HostSpan<double> x(data.x.data(), static_cast<Index>(data.x.size()));
  try {
    const auto problem = bundle::MakeDeviceBundleProblem(data);
    DeviceBuffer<double> on_device;
    on_device.CopyFrom(x);
    B backend;
    LmSummary summary = SolveLm<B>(options, backend, *problem, on_device.view(), callback);
    on_device.CopyTo(x);
    return summary;
  } catch (const OutOfDeviceMemory& error) {
    Fail(kOutOfMemory, "{}; use --device=cpu", error.what());
  }
}

}  // namespace vesta::app
