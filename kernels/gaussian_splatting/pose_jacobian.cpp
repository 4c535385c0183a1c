#include "kernels/gaussian_splatting/pose_jacobian.h"

#include "kernels/core/parallel.h"

namespace vesta::splat {
namespace {

constexpr Index kGrain = 1024;  // Gaussians; a multiple of every SIMD width

}  // namespace

template <class S>
void ApplyPoseJ(const SplatView<S>& view, const Model<S>& model, const PoseTangent& xi, S* d_image,
                ViewWorkspace<S>& workspace) {
  workspace.splat_sums.ResizeForOverwrite(view.num_splats());
  SplatTangent<S>* tangents = workspace.splat_sums.data();
  const auto& kernels = GetCameraKernels<S>(model.active_sh_degree);
  ParallelForChunks(model.count, kGrain, [&](Index begin, Index end) {
    kernels.tangent(model, view.camera(), xi, begin, end, view.rank_of().data(), tangents);
  });
  view.ApplyRasterJ(tangents, d_image);
}

template <class S>
PoseTangent ApplyPoseJT(const SplatView<S>& view, const Model<S>& model, const S* image, const S* u,
                        ViewWorkspace<S>& workspace) {
  const SplatTangent<S>* cotangents = view.ApplyRasterJT(image, u, workspace);
  const auto& kernels = GetCameraKernels<S>(model.active_sh_degree);
  return ParallelSum<PoseTangent>(model.count, kGrain, [&](Index begin, Index end) {
    return kernels.adjoint(model, view.camera(), begin, end, view.rank_of().data(), cotangents);
  });
}

template void ApplyPoseJ(const SplatView<float>&, const Model<float>&, const PoseTangent&, float*,
                         ViewWorkspace<float>&);
template void ApplyPoseJ(const SplatView<double>&, const Model<double>&, const PoseTangent&, double*,
                         ViewWorkspace<double>&);
template PoseTangent ApplyPoseJT(const SplatView<float>&, const Model<float>&, const float*, const float*,
                                 ViewWorkspace<float>&);
template PoseTangent ApplyPoseJT(const SplatView<double>&, const Model<double>&, const double*, const double*,
                                 ViewWorkspace<double>&);

}  // namespace vesta::splat
