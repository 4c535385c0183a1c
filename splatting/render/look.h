// SPDX-License-Identifier: Apache-2.0
// Images of per-Gaussian quantities, and views from any camera.
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

// Stores of(i), three floats for Gaussian i, as the colours of the visible splats in the workspace, and returns them by
// depth rank. The view must be built.
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

// An image with of(i) as the colour of Gaussian i, without a background: three planes, row by row. Images are linear in
// the colours, so the pass for the derivative computes this image. The view must not have a cached Jacobian. Takes the
// time of Render.
template <class Of>
std::vector<float> Blend(const splat::SplatView<float>& view, splat::ViewWorkspace<float>& workspace, const Of& of) {
  VESTA_CHECK(view.cache().empty(), "Blend does not support a cached Jacobian");
  std::vector<float> planes(static_cast<std::size_t>(3 * view.num_pixels()));
  view.ApplyRasterJ(AsColors(view, workspace, of), planes.data());
  return planes;
}

// Per pixel, of(i) for the Gaussian i at which the transmittance falls below one half, front to back; 0 if the
// transmittance stays above. Three planes.
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

// The view from `center` towards `target`, which must differ. `up` points upwards in the image; it is ignored if
// parallel to the viewing direction.
View LookingAt(const Camera& camera, const Point3& center, const Point3& target, const Point3& up);

// Mean viewing direction in world axes. Its length is 1 if all views look in one direction, and near 0 if they look in
// all directions.
Point3 MeanDirection(const std::vector<View>& views);

// Unit vector that points upwards in most views and is, by least squares, perpendicular to their image rows. It is the
// vertical if the cameras are level. It is opposite to the viewing direction of cameras that look straight down.
Point3 UpOf(const std::vector<View>& views);

// The point closest to the optical axes of the views, by least squares. If the axes are parallel, it is the point at
// the scene's median depth in front of the mean camera.
Point3 PointLookedAt(const Scene& scene);

}  // namespace vesta::gs
