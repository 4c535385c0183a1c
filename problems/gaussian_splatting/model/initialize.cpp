#include "problems/gaussian_splatting/model/initialize.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/model/knn.h"

namespace vesta::gs {

SplatModel InitializeFromPoints(const PointCloud& points, double extent, int sh_degree, Index max_gaussians) {
  VESTA_CHECK(points.size() > 0, "no points to start from");
  const Index count = std::min(points.size(), max_gaussians);
  std::vector<std::array<float, 3>> positions(static_cast<std::size_t>(count)), colors(positions);
  for (Index i = 0; i < count; ++i) {
    const auto from = static_cast<std::size_t>(i * points.size() / count);
    positions[static_cast<std::size_t>(i)] = points.positions[from];
    colors[static_cast<std::size_t>(i)] = points.colors[from];
  }
  const std::vector<float> distance2 = MeanSquaredNeighborDistance(positions);

  SplatModel model;
  model.Resize(sh_degree, count);
  constexpr float kInitialOpacity = 0.1f;
  constexpr double kSmallest = 1e-4;  // size of coinciding points, in extents
  const auto smallest = static_cast<float>(std::log(kSmallest * extent));
  for (Index i = 0; i < count; ++i) {
    const auto p = static_cast<std::size_t>(i);
    for (int k = 0; k < 3; ++k) {
      model.attribute(splat::kMean + k)[i] = positions[p][static_cast<std::size_t>(k)];
      model.attribute(splat::kLogScale + k)[i] = std::max(0.5f * std::log(distance2[p]), smallest);
      model.attribute(splat::kSh + k)[i] = (colors[p][static_cast<std::size_t>(k)] - 0.5f) / static_cast<float>(sh::k0);
    }
    model.attribute(splat::kQuaternion)[i] = 1;
    model.attribute(splat::kOpacity)[i] = std::log(kInitialOpacity / (1 - kInitialOpacity));
  }
  return model;
}

int DefaultShDegree(Index training_views) {
  constexpr Index kViewsForDegree3 = 24;
  return training_views < kViewsForDegree3 ? 2 : 3;
}

}  // namespace vesta::gs
