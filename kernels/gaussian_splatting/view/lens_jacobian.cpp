#include "kernels/gaussian_splatting/view/lens_jacobian.h"

#include "kernels/core/parallel.h"

namespace vesta::splat {
namespace {

constexpr Index kGrain = 1024;  // splats

}  // namespace

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
