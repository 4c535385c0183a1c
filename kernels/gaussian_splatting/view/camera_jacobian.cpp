// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/view/camera_jacobian.h"

#include "kernels/core/parallel.h"

namespace vesta::splat {
namespace {

constexpr Index kGrain = 1024;  // Gaussians; a multiple of every SIMD width

// Returns K xi, by rank.
template <class S>
const SplatTangent<S>* PoseTangents(const SplatView<S>& view, const Model<S>& model, const PoseTangent& xi,
                                    HostBuffer<SplatTangent<S>>& tangents) {
  if (tangents.size() < view.num_splats()) tangents.ResizeForOverwrite(view.num_splats());
  ParallelForChunks(model.count, kGrain, [&](Index begin, Index end) {
    model.ForEachDegree(begin, end, [&](int degree, Index from, Index to) {
      GetCameraKernels<S>(degree).tangent(model, view.camera(), xi, from, to, view.rank_of().data(), tangents.data());
    });
  });
  return tangents.data();
}

template <class S>
void Add(const SplatTangent<S>& tangent, SplatTangent<S>& sum) {
  for (int k = 0; k < kSplatTangent; ++k) sum.w[k] += tangent.w[k];
}

}  // namespace

template <class S>
void ApplyPoseJ(const SplatView<S>& view, const Model<S>& model, const PoseTangent& xi, S* d_image,
                ViewWorkspace<S>& workspace) {
  view.ApplyRasterJ(PoseTangents(view, model, xi, workspace.splat_sums), d_image);
}

template <class S>
void ApplyModelAndPoseJ(const SplatView<S>& view, const Model<S>& model, const S* dx, const PoseTangent* xi, S* d_image,
                        ViewWorkspace<S>& workspace) {
  SplatTangent<S>* tangents = view.ProjectTangents(model, dx, workspace);
  if (xi) {
    const SplatTangent<S>* moved = PoseTangents(view, model, *xi, workspace.pair_sums);  // unused by tangent passes
    ParallelFor(view.num_splats(), kGrain, [&](Index rank) { Add(moved[rank], tangents[rank]); });
  }
  view.ApplyRasterJ(tangents, d_image);
}

template <class S>
PoseTangent ApplyPoseJT(const SplatView<S>& view, const Model<S>& model, const S* image, const S* u,
                        ViewWorkspace<S>& workspace) {
  return PoseCotangent(view, model, view.ApplyRasterJT(image, u, workspace));
}

template <class S>
PoseTangent PoseCotangent(const SplatView<S>& view, const Model<S>& model, const SplatTangent<S>* cotangents) {
  return ParallelSum<PoseTangent>(model.count, kGrain, [&](Index begin, Index end) {
    PoseTangent sum;
    model.ForEachDegree(begin, end, [&](int degree, Index from, Index to) {
      sum += GetCameraKernels<S>(degree).adjoint(model, view.camera(), from, to, view.rank_of().data(), cotangents);
    });
    return sum;
  });
}

template void ApplyPoseJ(const SplatView<float>&, const Model<float>&, const PoseTangent&, float*,
                         ViewWorkspace<float>&);
template void ApplyPoseJ(const SplatView<double>&, const Model<double>&, const PoseTangent&, double*,
                         ViewWorkspace<double>&);
template void ApplyModelAndPoseJ(const SplatView<float>&, const Model<float>&, const float*, const PoseTangent*, float*,
                                 ViewWorkspace<float>&);
template void ApplyModelAndPoseJ(const SplatView<double>&, const Model<double>&, const double*, const PoseTangent*,
                                 double*, ViewWorkspace<double>&);
template PoseTangent ApplyPoseJT(const SplatView<float>&, const Model<float>&, const float*, const float*,
                                 ViewWorkspace<float>&);
template PoseTangent ApplyPoseJT(const SplatView<double>&, const Model<double>&, const double*, const double*,
                                 ViewWorkspace<double>&);
template PoseTangent PoseCotangent(const SplatView<float>&, const Model<float>&, const SplatTangent<float>*);
template PoseTangent PoseCotangent(const SplatView<double>&, const Model<double>&, const SplatTangent<double>*);

template <class S>
void ApplyLensJ(const SplatView<S>& view, const LensTangent& delta, S* d_image, ViewWorkspace<S>& workspace) {
  HostBuffer<SplatTangent<S>>& tangents = workspace.splat_sums;
  if (tangents.size() < view.num_splats()) tangents.ResizeForOverwrite(view.num_splats());
  ParallelFor(view.num_splats(), kGrain, [&](Index rank) {
    tangents[rank] = LensRows(view.splats()[rank], view.camera()).template Tangent<S>(delta);
  });
  view.ApplyRasterJ(tangents.data(), d_image);
}

template <class S>
LensTangent LensCotangent(const SplatView<S>& view, const SplatTangent<S>* cotangents) {
  return ParallelSum<LensTangent>(view.num_splats(), kGrain, [&](Index begin, Index end) {
    LensTangent sum;
    for (Index rank = begin; rank < end; ++rank) {
      LensRows(view.splats()[rank], view.camera()).AddCotangent(cotangents[rank], sum.v);
    }
    return sum;
  });
}

template void ApplyLensJ(const SplatView<float>&, const LensTangent&, float*, ViewWorkspace<float>&);
template void ApplyLensJ(const SplatView<double>&, const LensTangent&, double*, ViewWorkspace<double>&);
template LensTangent LensCotangent(const SplatView<float>&, const SplatTangent<float>*);
template LensTangent LensCotangent(const SplatView<double>&, const SplatTangent<double>*);

}  // namespace vesta::splat
