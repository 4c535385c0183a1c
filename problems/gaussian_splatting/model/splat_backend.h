// SPDX-License-Identifier: Apache-2.0
// Types that depend on the memory space, CPU or GPU. The problem, the training stages and the evaluation are templates
// on a backend B (kernels/core/vector_backend.h) for vectors; SplatBackend<B> has the other types. This file is for the
// CPU, device_splat_backend.h for the GPU.
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
  // The photograph of a view: three planes. It refers to the image in the scene; the image must outlive it.
  using Truth = HostSpan<const S>;
  static Truth MakeTruth(HostSpan<const S> truth) { return truth; }
  // Additional memory of the truth.
  static double TruthBytes(double /*pixels*/) { return 0; }
  // Sets `to` to `from`. On the GPU this copies the pixels, because the quality meter there may change them.
  static void CopyTruth(HostSpan<const S> from, Truth& to) { to = from; }
  // The pixel mask; it refers to Image::mask.
  using Mask = HostSpan<const std::uint8_t>;
  static Mask MakeMask(HostSpan<const std::uint8_t> mask) { return mask; }
};

// One view: its camera, and its photograph.
template <class B>
struct TargetView {
  splat::PosedCamera camera;
  typename SplatBackend<B>::Truth truth;              // 3 planes
  typename SplatBackend<B>::Mask mask = {};           // included pixels; empty: all
  typename SplatBackend<B>::Truth transparency = {};  // one plane, Image::transparency; empty: opaque

  ImageShape shape() const { return {camera.width, camera.height}; }
};

// Converts views in CPU memory to the memory of B. For a CPU backend the result refers to the same images, which must
// outlive it; else it has copies.
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
