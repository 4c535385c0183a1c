// Numbers of single Gaussians as images.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/raster/median_kernels.h"
#include "kernels/gaussian_splatting/view/splat_view.h"

namespace vesta::gs {

// of(i), three floats of Gaussian i, as the colours of its splat; by rank, in the workspace. view: built.
template <class Of>
const splat::SplatTangent<float>* AsColors(const splat::SplatView<float>& view, splat::ViewWorkspace<float>& workspace,
                                           const Of& of) {
  constexpr Index kGrain = 1024;
  auto& tangents = workspace.splat_sums;
  if (tangents.size() < view.num_splats()) tangents.ResizeForOverwrite(view.num_splats());
  ParallelFor(view.rank_of().size(), kGrain, [&](Index i) {
    const std::int32_t rank = view.rank_of()[i];
    if (rank < 0) return;
    splat::SplatTangent<float> tangent{};
    const std::array<float, 3> value = of(i);
    std::copy_n(value.data(), 3, tangent.w + splat::kColor);
    tangents[rank] = tangent;
  });
  return tangents.data();
}

// Three planes of the sum over the splats of weight times of(i): an image is linear in the colours of its splats, so
// that is the image's derivative along colours alone. Nothing is behind them. No Jacobian may be cached. Takes as long
// as Render.
template <class Of>
std::vector<float> Blend(const splat::SplatView<float>& view, splat::ViewWorkspace<float>& workspace, const Of& of) {
  VESTA_CHECK(view.cache().empty(), "what is blended is not of the cached Jacobian");
  std::vector<float> planes(static_cast<std::size_t>(3 * view.num_pixels()));
  view.ApplyRasterJ(AsColors(view, workspace, of), planes.data());
  return planes;
}

// Three planes of of(i) of the Gaussian at which the transmittance falls below one half; 0 where none is.
template <class Of>
std::vector<float> AtMedian(const splat::SplatView<float>& view, splat::ViewWorkspace<float>& workspace, const Of& of) {
  std::vector<float> planes(static_cast<std::size_t>(3 * view.num_pixels()));
  const splat::SplatTangent<float>* values = AsColors(view, workspace, of);
  const splat::TileLists<float> lists = view.Lists();
  ParallelFor(view.num_tiles(), 8, [&, kernel = splat::GetMedianKernel<float>()](Index tile) {
    kernel(lists, static_cast<int>(tile), values, planes.data());
  });
  return planes;
}

}  // namespace vesta::gs
