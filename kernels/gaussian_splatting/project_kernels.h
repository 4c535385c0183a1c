// Projection passes over ranges of Gaussians, for the instruction set chosen at run time.
#pragma once

#include "kernels/gaussian_splatting/posed_camera.h"
#include "kernels/gaussian_splatting/types.h"

namespace vesta::splat {

// A model: x as in layout.h, `count` Gaussians, SH degree `sh_degree` stored; colours use bands up to active_sh_degree.
template <class S>
struct Model {
  const S* x;
  std::int64_t count;
  int sh_degree;
  int active_sh_degree;
};

// Sort key of a Gaussian that is not seen.
inline constexpr std::uint32_t kNotSeen = 0xffffffffu;

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
  // [PackedLower(row, col) * count + i]), sh_diagonal[a' * count + i] += the diagonal for attribute kSh + a'. Unless
  // null, sh_blocks += the blocks of the SH coefficients, laid out likewise: the mean of the channels', which differ in
  // weight alone.
  void (*gram)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
               const std::int32_t* rank_of, const SplatGram<S>* grams, S* blocks, S* sh_diagonal, S* sh_blocks);
};

// The kernels for models with this active SH degree (0..3).
template <class S>
const ProjectKernels<S>& GetProjectKernels(int active_sh_degree);

}  // namespace vesta::splat
