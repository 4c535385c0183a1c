// SPDX-License-Identifier: Apache-2.0
// What the trainer uses in a memory space, beside vectors (kernels/core/vector_backend.h). The problem, the stages and
// the evaluation are templates over a vector backend B and take all that differs from SplatBackend<B>: here the host's,
// in device_splat_backend.h the GPU's.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/vector_backend.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "kernels/image/image_shape.h"
#include "kernels/image/metrics.h"
#include "kernels/image/photometric_loss.h"

namespace vesta::gs {

template <class B>
struct SplatBackend;

template <class S>
struct SplatBackend<CpuBackend<S>> {
  using SplatView = splat::SplatView<S>;
  using Workspace = splat::ViewWorkspace<S>;
  using Loss = PhotometricLoss<S>;
  using QualityMeter = ImageQualityMeter;
  // The truth of a view: that of the scene itself, which must outlive its users.
  using Truth = HostSpan<const S>;
  static Truth MakeTruth(HostSpan<const S> truth) { return truth; }
  static double TruthBytes(double /*pixels*/) { return 0; }
  // to becomes a truth that the quality meter may write into where it does.
  static void CopyTruth(HostSpan<const S> from, Truth& to) { to = from; }
  // Of its pixels, as Image::mask: that of the scene itself.
  using Mask = HostSpan<const std::uint8_t>;
  static Mask MakeMask(HostSpan<const std::uint8_t> mask) { return mask; }
};

// One view to fit.
template <class B>
struct TargetView {
  splat::PosedCamera camera;
  typename SplatBackend<B>::Truth truth;     // 3 planes
  typename SplatBackend<B>::Mask mask = {};  // which pixels count; empty: all

  ImageShape shape() const { return {camera.width, camera.height}; }
};

// Views of the host in the memory of B, for whom the former must stay where that is the host's.
template <class B>
std::vector<TargetView<B>> TargetsIn(const std::vector<TargetView<CpuBackend<typename B::Scalar>>>& views) {
  std::vector<TargetView<B>> targets;
  targets.reserve(views.size());
  for (const auto& view : views) {
    targets.push_back({view.camera, SplatBackend<B>::MakeTruth(view.truth), SplatBackend<B>::MakeMask(view.mask)});
  }
  return targets;
}

}  // namespace vesta::gs
