// SPDX-License-Identifier: Apache-2.0
// Images of a model from any camera.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/raster/raster_kernels.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/scene/scene.h"

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

using Point3 = std::array<double, 3>;

// The view from `center` towards `target`, with `up` upwards in its image, or anything where it looks along that.
// target and center differ.
View LookingAt(const Camera& camera, const Point3& center, const Point3& target, const Point3& up);

// The mean of the directions that the views look in, world axes: 1 long where all look one way, 0 where they look
// everywhere.
Point3 MeanDirection(const std::vector<View>& views);

// The direction, of length 1, across the rows of the views' images that is upwards in them on the whole: vertical, as
// far as cameras are held level. For cameras that look down at all turns it is what is behind them.
Point3 UpOf(const std::vector<View>& views);

// The point nearest to the optical axes of the views, by least squares. What parallel axes leave open is decided by the
// scene's extent: the median depth before the middle of the cameras.
Point3 PointLookedAt(const Scene& scene);

}  // namespace vesta::gs
