// SPDX-License-Identifier: Apache-2.0
// Passes over ranges of Gaussians, for the instruction set chosen at run time: their projection, and the derivatives of
// splats with respect to the camera of their view.
#pragma once

#include <algorithm>

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::splat {

// A model: values x with this layout. Colours use bands up to active_sh_degree, which must not exceed sh_degree.
template <class S>
struct Model : ModelLayout {
  const S* x = nullptr;
  int active_sh_degree = 0;

  Model() = default;
  Model(const S* values, const ModelLayout& layout, int active)
      : ModelLayout(layout), x(values), active_sh_degree(active) {}
  // A model in which all Gaussians have the same degree.
  Model(const S* values, std::int64_t gaussians, int degree, int active)
      : Model(values, ModelLayout{.count = gaussians, .sh_degree = degree}, active) {}

  // Splits [begin, end) by degree and calls body(degree, begin, end) for each piece; its Gaussians have colours of that
  // degree.
  template <class Body>
  void ForEachDegree(std::int64_t begin, std::int64_t end, const Body& body) const {
    for (int degree = active_sh_degree; degree >= 0; --degree) {
      const std::int64_t until = std::min(end, WithBand(degree));
      if (begin < until) body(degree, begin, until);
      begin = std::max(begin, until);
    }
  }
};

// Sort key of a Gaussian that is not visible.
inline constexpr std::uint32_t kInvisible = 0xffffffffu;

// Kernels for one SH degree, for ranges of Gaussians whose colours have exactly that degree (Model::ForEachDegree).
template <class S>
struct ProjectKernels {
  // For Gaussians [begin, end): key[i] = the bits of the depth as float (ascending with depth), or kInvisible. If
  // visible, also splats[i]. Not visible: at or before the near plane, opacity under 1/255, support outside the image,
  // or any non-finite value.
  void (*project)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  std::uint32_t* key, Splat<S>* splats);
  // tangents[rank] = K dx for Gaussians [begin, end) with rank = rank_of[i] >= 0. dx has the layout of x.
  void (*tangent)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  const std::int32_t* rank_of, const S* dx, SplatTangent<S>* tangents);
  // g += K^T cotangents[rank]. Gaussians that are not visible add nothing.
  void (*adjoint)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  const std::int32_t* rank_of, const SplatTangent<S>* cotangents, S* g);
  // blocks += K^T Gram K for the geometric attributes: element (row, col) of the packed lower triangle of Gaussian i is
  // at [PackedLower(row, col) * count + i]. sh_diagonal += the diagonal for the other attributes, in the layout of x
  // without the geometric attributes.
  void (*gram)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
               const std::int32_t* rank_of, const SplatGram<S>* grams, S* blocks, S* sh_diagonal);
};

// The kernels for this degree (0..3).
template <class S>
const ProjectKernels<S>& GetProjectKernels(int degree);
// The float kernels of one instruction set, which the CPU must support.
const ProjectKernels<float>& FloatProjectKernelsFor(Isa isa, int degree);

// A tangent or cotangent of SE(3) at a camera, in the camera's frame: it maps a point t in camera coordinates to
// exp(rotation) t + translation. Rotation in radians, translation in world units.
inline constexpr int kPoseTangent = 6;
struct PoseTangent {
  double v[kPoseTangent] = {};  // rotation, then translation

  PoseTangent& operator+=(const PoseTangent& other) {
    for (int k = 0; k < kPoseTangent; ++k) v[k] += other.v[k];
    return *this;
  }
};

// K is the derivative of the splats with respect to the pose, for Gaussians of one SH degree (Model::ForEachDegree).
// Visibility and depth order are treated as constant.
template <class S>
struct CameraKernels {
  // tangents[rank] = K xi for Gaussians [begin, end) with rank = rank_of[i] >= 0.
  void (*tangent)(const Model<S>& model, const PosedCamera& view, const PoseTangent& xi, std::int64_t begin,
                  std::int64_t end, const std::int32_t* rank_of, SplatTangent<S>* tangents);
  // K^T cotangents of the same Gaussians, added one after the other in double.
  PoseTangent (*adjoint)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                         const std::int32_t* rank_of, const SplatTangent<S>* cotangents);
};

// The kernels for this degree (0..3). S = double is the reference in tests.
template <class S>
const CameraKernels<S>& GetCameraKernels(int degree);
const CameraKernels<float>& FloatCameraKernelsFor(Isa isa, int degree);

}  // namespace vesta::splat
