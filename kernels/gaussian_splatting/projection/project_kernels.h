// SPDX-License-Identifier: Apache-2.0
// Passes over ranges of Gaussians, for the instruction set chosen at run time: the projection of Gaussians to splats,
// and the derivatives of the projection with respect to the Gaussians' parameters and the camera pose.
#pragma once

#include <algorithm>

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::splat {

// A model: values x with this layout (not owned). Colours use SH bands up to active_sh_degree <= sh_degree.
template <class S>
struct Model : ModelLayout {
  const S* x = nullptr;
  int active_sh_degree = 0;

  Model() = default;
  Model(const S* values, const ModelLayout& layout, int active)
      : ModelLayout(layout), x(values), active_sh_degree(active) {}
  // All Gaussians have the same degree.
  Model(const S* values, std::int64_t gaussians, int degree, int active)
      : Model(values, ModelLayout{.count = gaussians, .sh_degree = degree}, active) {}

  // Divides the Gaussians begin .. end - 1 into ranges of equal SH degree, at most active_sh_degree, and calls
  // body(degree, begin, end) for each.
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

// Kernels for ranges of Gaussians whose colours have exactly one SH degree (Model::ForEachDegree). rank_of[i] is the
// index of Gaussian i in depth order (its rank), or -1 if it is not visible. K is the derivative of a splat, as a
// SplatTangent, with respect to the parameters of its Gaussian.
template <class S>
struct ProjectKernels {
  // For Gaussians [begin, end): key[i] = the bits of the depth as float, which increase with the depth; kInvisible if
  // not visible. Computes splats[i] if visible. A Gaussian is not visible if its depth is not above `near`, its opacity
  // is below 1/255, its support is outside the image, a value is not finite, or a limit of project.h is exceeded.
  void (*project)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  std::uint32_t* key, Splat<S>* splats);
  // tangents[rank] = K dx for the visible Gaussians in [begin, end). dx: change of the parameters, in the layout of x.
  void (*tangent)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  const std::int32_t* rank_of, const S* dx, SplatTangent<S>* tangents);
  // g += K^T cotangents[rank] for the same Gaussians. g has the layout of x.
  void (*adjoint)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  const std::int32_t* rank_of, const SplatTangent<S>* cotangents, S* g);
  // blocks += K^T Gram K for the geometric attributes, with the splat's Gram matrix (grams[rank]). Element (row, col)
  // of the packed lower triangle of Gaussian i is blocks[PackedLower(row, col) * count + i]. sh_diagonal += the
  // diagonal of K^T Gram K for the SH attributes, in the layout of x without the geometric attributes.
  void (*gram)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
               const std::int32_t* rank_of, const SplatGram<S>* grams, S* blocks, S* sh_diagonal);
};

// The kernels for this SH degree (0..3).
template <class S>
const ProjectKernels<S>& GetProjectKernels(int degree);
// The float kernels of `isa`, which the CPU must support.
const ProjectKernels<float>& FloatProjectKernelsFor(Isa isa, int degree);

// A tangent or cotangent of a camera pose (of SE(3)), in the camera's frame. It maps a point t in camera coordinates to
// exp(rotation) t + translation. Radians and world units.
inline constexpr int kPoseTangent = 6;
struct PoseTangent {
  double v[kPoseTangent] = {};  // rotation, then translation

  PoseTangent& operator+=(const PoseTangent& other) {
    for (int k = 0; k < kPoseTangent; ++k) v[k] += other.v[k];
    return *this;
  }
};

// Kernels for one SH degree, as in ProjectKernels. K is the derivative of a splat with respect to the camera pose, with
// constant visibility and depth order.
template <class S>
struct CameraKernels {
  // tangents[rank] = K xi for the visible Gaussians in [begin, end).
  void (*tangent)(const Model<S>& model, const PosedCamera& view, const PoseTangent& xi, std::int64_t begin,
                  std::int64_t end, const std::int32_t* rank_of, SplatTangent<S>* tangents);
  // Returns the sum of K^T cotangents[rank] over the same Gaussians, added in double in the order of the Gaussians.
  PoseTangent (*adjoint)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                         const std::int32_t* rank_of, const SplatTangent<S>* cotangents);
};

// S = double is the reference in tests.
template <class S>
const CameraKernels<S>& GetCameraKernels(int degree);
const CameraKernels<float>& FloatCameraKernelsFor(Isa isa, int degree);

}  // namespace vesta::splat
