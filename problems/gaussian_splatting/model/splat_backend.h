// SPDX-License-Identifier: Apache-2.0
// The types that the trainer needs in a memory space, in addition to vectors (kernels/core/vector_backend.h). The
// problem, the stages and the evaluation are templates over a vector backend B and take everything else from
// SplatBackend<B>. The host's is here, the GPU's in device_splat_backend.h.
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
  // The truth image of a view. A reference to the scene's own image, which must outlive its users.
  using Truth = HostSpan<const S>;
  static Truth MakeTruth(HostSpan<const S> truth) { return truth; }
  static double TruthBytes(double /*pixels*/) { return 0; }
  // Sets `to` to `from`. On the device this is a copy, because the quality meter there may write into it.
  static void CopyTruth(HostSpan<const S> from, Truth& to) { to = from; }
  // The pixel mask, as Image::mask: also a reference into the scene.
  using Mask = HostSpan<const std::uint8_t>;
  static Mask MakeMask(HostSpan<const std::uint8_t> mask) { return mask; }
};

// One view to fit.
template <class B>
struct TargetView {
  splat::PosedCamera camera;
  typename SplatBackend<B>::Truth truth;     // 3 planes
  typename SplatBackend<B>::Mask mask = {};  // included pixels; empty: all

  ImageShape shape() const { return {camera.width, camera.height}; }
};

// Host views in the memory of B. If B is the host, the result refers to the images of `views`, which must outlive it.
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
