// SPDX-License-Identifier: Apache-2.0
// Projection on a GPU: one Gaussian per thread. Neighbouring threads read neighbouring values of each attribute.
#include "kernels/gaussian_splatting/device/device_by_degree.cuh"
#include "kernels/gaussian_splatting/device/device_passes.h"
#include "kernels/gaussian_splatting/projection/project_block.h"

namespace vesta::splat::device_passes {
namespace {

// Thread k processes Gaussian first + k.
template <int kDegree, class L>
struct ProjectOne {
  Model<float> model;
  CameraConstants<float, L> camera;
  Index first;
  std::uint32_t *keys, *indices;
  Splat<float>* splats;
  VESTA_HD void operator()(Index k) const {
    const Index i = first + k;
    ProjectRange<float, float, kDegree>(model, camera, i, i + 1, keys, splats);
    indices[i] = static_cast<std::uint32_t>(i);
  }
};

template <int kDegree, class L>
struct TangentOne {
  Model<float> model;
  CameraConstants<float, L> camera;
  Index first;
  const std::int32_t* rank_of;
  const float* dx;
  SplatTangent<float>* tangents;
  VESTA_HD void operator()(Index k) const {
    const Index i = first + k;
    TangentRange<float, float, kDegree>(model, camera, i, i + 1, rank_of, dx, tangents);
  }
};

template <int kDegree, class L>
struct AdjointOne {
  static constexpr int kMinBlocks = 1;
  Model<float> model;
  CameraConstants<float, L> camera;
  Index first;
  const std::int32_t* rank_of;
  const SplatTangent<float>* cotangents;
  float* g;
  VESTA_HD void operator()(Index k) const {
    const Index i = first + k;
    AdjointRange<float, float, kDegree>(model, camera, i, i + 1, rank_of, cotangents, g);
  }
};

template <int kDegree, class L>
struct GramOne {
  Model<float> model;
  CameraConstants<float, L> camera;
  Index first;
  const std::int32_t* rank_of;
  const SplatGram<float>* grams;
  float *blocks, *sh_diagonal;
  VESTA_HD void operator()(Index k) const {
    const Index i = first + k;
    GramRange<float, float, kDegree>(model, camera, i, i + 1, rank_of, grams, blocks, sh_diagonal);
  }
};

}  // namespace

void Project(const Model<float>& model, const PosedCamera& view, std::uint32_t* keys, std::uint32_t* indices,
             Splat<float>* splats) {
  RunByDegree<ProjectOne>(model, view, "projection", keys, indices, splats);
}

void ProjectTangent(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of, const float* dx,
                    SplatTangent<float>* tangents) {
  RunByDegree<TangentOne>(model, view, "tangent of the projection", rank_of, dx, tangents);
}

void ProjectAdjoint(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                    const SplatTangent<float>* cotangents, float* g) {
  RunByDegree<AdjointOne>(model, view, "adjoint of the projection", rank_of, cotangents, g);
}

void ProjectGram(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                 const SplatGram<float>* grams, float* blocks, float* sh_diagonal) {
  RunByDegree<GramOne>(model, view, "Gram blocks of the projection", rank_of, grams, blocks, sh_diagonal);
}

}  // namespace vesta::splat::device_passes
