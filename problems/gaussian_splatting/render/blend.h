// Numbers of single Gaussians as images.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/splat_view.h"

namespace vesta::gs {

// Three planes of the sum over the splats of weight times of(i), i the Gaussian, of(i) three floats: an image is linear
// in the colours of its splats, so that is the image's derivative along colours alone. Nothing is behind them. view:
// built; no Jacobian may be cached. Takes as long as Render.
template <class Of>
std::vector<float> Blend(const splat::SplatView<float>& view, splat::ViewWorkspace<float>& workspace, const Of& of) {
  constexpr Index kGrain = 1024;
  VESTA_CHECK(view.cache().empty(), "what is blended is not of the cached Jacobian");
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
  std::vector<float> planes(static_cast<std::size_t>(3 * view.num_pixels()));
  view.ApplyRasterJ(tangents.data(), planes.data());
  return planes;
}

}  // namespace vesta::gs
