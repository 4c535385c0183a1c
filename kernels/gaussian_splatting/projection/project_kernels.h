// SPDX-License-Identifier: Apache-2.0
// Passes over ranges of Gaussians, for the instruction set chosen at run time: their projection, and how splats move
// with the camera of their view.
#pragma once

#include <algorithm>

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::splat {

// A model: x laid out so; colours use bands up to active_sh_degree, which is not above sh_degree.
template <class S>
struct Model : ModelLayout {
  const S* x = nullptr;
  int active_sh_degree = 0;

  Model() = default;
  Model(const S* values, const ModelLayout& layout, int active)
      : ModelLayout(layout), x(values), active_sh_degree(active) {}
  // Of Gaussians that all have the same degree.
  Model(const S* values, std::int64_t gaussians, int degree, int active)
      : Model(values, ModelLayout{.count = gaussians, .sh_degree = degree}, active) {}

  // body(degree, begin, end) for [begin, end) piece by piece: the Gaussians of each have colours of that degree.
  template <class Body>
  void ForEachDegree(std::int64_t begin, std::int64_t end, const Body& body) const {
    for (int degree = active_sh_degree; degree >= 0; --degree) {
      const std::int64_t until = std::min(end, WithBand(degree));
      if (begin < until) body(degree, begin, until);
      begin = std::max(begin, until);
    }
  }
};

// Sort key of a Gaussian that is not seen.
inline constexpr std::uint32_t kNotSeen = 0xffffffffu;

// Of a degree: for ranges of Gaussians whose colours have just that one (Model::ForEachDegree).
template <class S>
struct ProjectKernels {
  // For Gaussians [begin, end): key[i] = the bits of the depth as float (ascending with depth), or kNotSeen; where
  // seen, splats[i]. Not seen: at or before the near plane, opacity under 1/255, support outside the image, or anything
  // not finite.
  void (*project)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  std::uint32_t* key, Splat<S>* splats);
  // tangents[rank] = K dx for Gaussians [begin, end) with rank = rank_of[i] >= 0. dx is laid out as x.
  void (*tangent)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  const std::int32_t* rank_of, const S* dx, SplatTangent<S>* tangents);
  // g += K^T cotangents[rank]; Gaussians not seen add nothing.
  void (*adjoint)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                  const std::int32_t* rank_of, const SplatTangent<S>* cotangents, S* g);
  // blocks += K^T Gram K restricted to the geometric attributes (packed lower triangle (row, col) of Gaussian i at
  // [PackedLower(row, col) * count + i]), sh_diagonal += the diagonal of the others, laid out as x without the
  // geometric attributes.
  void (*gram)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
               const std::int32_t* rank_of, const SplatGram<S>* grams, S* blocks, S* sh_diagonal);
};

// The kernels of this degree (0..3).
template <class S>
const ProjectKernels<S>& GetProjectKernels(int degree);
// The float kernels of a named instruction set, which the CPU must have: for the dispatch, and for tests that compare
// one set with another.
const ProjectKernels<float>& FloatProjectKernelsFor(Isa isa, int degree);

// A tangent of SE(3) at a camera, or a cotangent, in the camera's own frame: a point t in camera coordinates goes to
// exp(rotation) t + translation. Rotation in radians, translation in world units.
inline constexpr int kPoseTangent = 6;
struct PoseTangent {
  double v[kPoseTangent] = {};  // rotation, then translation

  PoseTangent& operator+=(const PoseTangent& other) {
    for (int k = 0; k < kPoseTangent; ++k) v[k] += other.v[k];
    return *this;
  }
};

// K is the derivative of the splats by the pose; of a degree, for ranges of Gaussians whose colours have just that one
// (Model::ForEachDegree). What is seen, and in which order, stays.
template <class S>
struct CameraKernels {
  // tangents[rank] = K xi for Gaussians [begin, end) with rank = rank_of[i] >= 0.
  void (*tangent)(const Model<S>& model, const PosedCamera& view, const PoseTangent& xi, std::int64_t begin,
                  std::int64_t end, const std::int32_t* rank_of, SplatTangent<S>* tangents);
  // K^T cotangents of those Gaussians, summed one after the other in double.
  PoseTangent (*adjoint)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                         const std::int32_t* rank_of, const SplatTangent<S>* cotangents);
};

// The kernels of this degree (0..3). S = double is the reference of the tests.
template <class S>
const CameraKernels<S>& GetCameraKernels(int degree);
const CameraKernels<float>& FloatCameraKernelsFor(Isa isa, int degree);

}  // namespace vesta::splat
