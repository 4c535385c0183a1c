#include "problems/gaussian_splatting/model/knn.h"

#include <nanoflann.hpp>

#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

using Points = std::vector<std::array<float, 3>>;

// What nanoflann asks of a data set; the names are its own.
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
    // The nearest of all is the point itself or one that coincides with it: distance 0 either way.
    std::array<std::uint32_t, 4> neighbors;
    std::array<double, 4> distances;
    const std::size_t found = tree.knnSearch(query, 4, neighbors.data(), distances.data());
    double sum = 0;
    for (std::size_t k = 1; k < found; ++k) sum += distances[k];
    means[static_cast<std::size_t>(i)] = found > 1 ? static_cast<float>(sum / static_cast<double>(found - 1)) : 0.0f;
  });
  return means;
}

}  // namespace vesta::gs
