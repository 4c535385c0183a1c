// SPDX-License-Identifier: Apache-2.0
// SplatBackend (splat_backend.h) for GPU memory, with copies of photographs and masks.
#pragma once

#include "kernels/core/cuda_backend.h"
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "kernels/image/device_photometric_loss.h"
#include "problems/gaussian_splatting/model/splat_backend.h"

namespace vesta::gs {

template <>
struct SplatBackend<CudaBackend<float>> {
  using SplatView = splat::DeviceSplatView;
  using Workspace = splat::DeviceViewWorkspace;
  using Loss = DevicePhotometricLoss;
  using QualityMeter = DeviceImageQualityMeter;
  // The photograph of a view, three planes, or its transparency.
  using Truth = DeviceBuffer<float>;
  static Truth MakeTruth(HostSpan<const float> truth) {
    Truth copy;
    if (truth.size() > 0) CopyTruth(truth, copy);
    return copy;
  }
  using Mask = DeviceBuffer<std::uint8_t>;
  static Mask MakeMask(HostSpan<const std::uint8_t> mask) {
    Mask copy;
    if (mask.size() > 0) copy.CopyFrom(mask);
    return copy;
  }
  static double TruthBytes(double pixels) { return ImageShape::kChannels * sizeof(float) * pixels; }
  template <class Space>
  static void CopyTruth(Span<const float, Space> from, Truth& to) {
    to.CopyFrom(from);
  }
  static void CopyMask(HostSpan<const std::uint8_t> from, Mask& to) { to.CopyFrom(from); }
};

}  // namespace vesta::gs
