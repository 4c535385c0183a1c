// Projection on a GPU: a Gaussian a thread, neighbours reading neighbouring values of each attribute.
#include "kernels/core/launch.cuh"
#include "kernels/gaussian_splatting/device_passes.h"
#include "kernels/gaussian_splatting/project_block.h"

namespace vesta::splat::device_passes {
namespace {

template <int kDegree>
struct ProjectOne {
  Model<float> model;
  CameraConstants<float> camera;
  std::uint32_t *keys, *indices;
  Splat<float>* splats;
  VESTA_HD void operator()(Index i) const {
    ProjectRange<float, float, kDegree>(model, camera, i, i + 1, keys, splats);
    indices[i] = static_cast<std::uint32_t>(i);
  }
};

template <int kDegree>
struct TangentOne {
  Model<float> model;
  CameraConstants<float> camera;
  const std::int32_t* rank_of;
  const float* dx;
  SplatTangent<float>* tangents;
  VESTA_HD void operator()(Index i) const {
    TangentRange<float, float, kDegree>(model, camera, i, i + 1, rank_of, dx, tangents);
  }
};

template <int kDegree>
struct AdjointOne {
  static constexpr int kMinBlocks = 1;
  Model<float> model;
  CameraConstants<float> camera;
  const std::int32_t* rank_of;
  const SplatTangent<float>* cotangents;
  float* g;
  VESTA_HD void operator()(Index i) const {
    AdjointRange<float, float, kDegree>(model, camera, i, i + 1, rank_of, cotangents, g);
  }
};

template <int kDegree>
struct GramOne {
  Model<float> model;
  CameraConstants<float> camera;
  const std::int32_t* rank_of;
  const SplatGram<float>* grams;
  float *blocks, *sh_diagonal, *sh_blocks;
  VESTA_HD void operator()(Index i) const {
    GramRange<float, float, kDegree>(model, camera, i, i + 1, rank_of, grams, blocks, sh_diagonal, sh_blocks);
  }
};

// One<degree>{model, camera, rest...} for every Gaussian, with the model's active degree.
template <template <int> class One, class... Rest>
void RunForDegree(const Model<float>& model, const PosedCamera& view, const char* name, Rest... rest) {
  const CameraConstants<float> camera = ConstantsOf<float>(view);
  switch (model.active_sh_degree) {
    case 0:
      return device::ForEach(model.count, One<0>{model, camera, rest...}, name);
    case 1:
      return device::ForEach(model.count, One<1>{model, camera, rest...}, name);
    case 2:
      return device::ForEach(model.count, One<2>{model, camera, rest...}, name);
    default:
      return device::ForEach(model.count, One<3>{model, camera, rest...}, name);
  }
}

}  // namespace

void Project(const Model<float>& model, const PosedCamera& view, std::uint32_t* keys, std::uint32_t* indices,
             Splat<float>* splats) {
  RunForDegree<ProjectOne>(model, view, "projection", keys, indices, splats);
}

void ProjectTangent(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of, const float* dx,
                    SplatTangent<float>* tangents) {
  RunForDegree<TangentOne>(model, view, "tangent of the projection", rank_of, dx, tangents);
}

void ProjectAdjoint(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                    const SplatTangent<float>* cotangents, float* g) {
  RunForDegree<AdjointOne>(model, view, "adjoint of the projection", rank_of, cotangents, g);
}

void ProjectGram(const Model<float>& model, const PosedCamera& view, const std::int32_t* rank_of,
                 const SplatGram<float>* grams, float* blocks, float* sh_diagonal, float* sh_blocks) {
  RunForDegree<GramOne>(model, view, "Gram blocks of the projection", rank_of, grams, blocks, sh_diagonal, sh_blocks);
}

}  // namespace vesta::splat::device_passes
