// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/initialize.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/profile.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {
namespace {

using Points = std::vector<std::array<float, 3>>;

// The data set interface of nanoflann, which dictates the names.
struct PointSet {
  const Points& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Metric = nanoflann::L2_Simple_Adaptor<double, PointSet>;
using Tree = nanoflann::KDTreeSingleIndexAdaptor<Metric, PointSet, 3>;

}  // namespace

std::vector<float> MeanSquaredNeighborDistance(const Points& positions) {
  std::vector<float> means(positions.size());
  const PointSet set{positions};
  const Tree tree(3, set);
  ParallelFor(static_cast<Index>(positions.size()), 256, [&](Index i) {
    const auto& p = positions[static_cast<std::size_t>(i)];
    const double query[3] = {p[0], p[1], p[2]};
    // The nearest point is the point itself or one that coincides with it: distance 0 either way.
    std::array<std::uint32_t, 4> neighbors;
    std::array<double, 4> distances;
    const std::size_t found = tree.knnSearch(query, 4, neighbors.data(), distances.data());
    double sum = 0;
    for (std::size_t k = 1; k < found; ++k) sum += distances[k];
    means[static_cast<std::size_t>(i)] = found > 1 ? static_cast<float>(sum / static_cast<double>(found - 1)) : 0.0f;
  });
  return means;
}

SplatModel InitializeFromPoints(const PointCloud& points, double extent, int sh_degree, Index max_gaussians) {
  const ScopedPhase phase("initial Gaussians");
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
  constexpr double kSmallest = 1e-4;  // size of coinciding points, as a fraction of the extent
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

namespace {

constexpr int kBits = 21;

// Inserts two zero bits after each bit of a number of kBits bits.
std::uint64_t Spread(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

}  // namespace

std::vector<Index> SpatialOrder(const SplatModel& model) {
  const auto n = static_cast<std::size_t>(model.count);
  std::vector<std::pair<std::uint64_t, Index>> codes(n);
  for (std::size_t i = 0; i < n; ++i) codes[i].second = static_cast<Index>(i);
  for (int k = 0; k < 3; ++k) {
    const float* mean = model.attribute(splat::kMean + k);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < n; ++i) {
      if (!std::isfinite(mean[i])) continue;
      low = std::min<double>(low, mean[i]);
      high = std::max<double>(high, mean[i]);
    }
    constexpr double kLast = (1 << kBits) - 1;
    const double scale = high > low ? kLast / (high - low) : 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double cell = std::isfinite(mean[i]) ? (mean[i] - low) * scale : kLast;
      codes[i].first |= Spread(static_cast<std::uint64_t>(cell)) << k;
    }
  }
  for (int degree = model.sh_degree; degree >= 0; --degree) {
    std::sort(codes.begin() + model.WithBand(degree + 1), codes.begin() + model.WithBand(degree));
  }
  std::vector<Index> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = codes[i].second;
  return order;
}

SplatModel InOrder(SplatModel model, const std::vector<Index>& order) {
  const std::vector<std::uint32_t> source(order.begin(), order.end());
  const splat::ModelLayout layout = LayoutOfRows(model, source);
  return TakeGaussians(std::move(model), {source, layout});
}

}  // namespace vesta::gs
