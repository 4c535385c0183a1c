// SPDX-License-Identifier: Apache-2.0
#include "bench/collections/wrong_closures.h"

#include <cmath>
#include <numbers>

#include "kernels/core/check.h"
#include "kernels/core/random.h"
#include "problems/pose_graph/closure_check.h"

namespace vesta::bench {
namespace {

using pose_graph::PoseGraph;

int Dimensions(const PoseGraph& graph) { return graph.space == pose_graph::PoseSpace::kSe2 ? 2 : 3; }

// A uniformly random rotation, and a position in a cube of this extent.
std::vector<double> RandomPose(const PoseGraph& graph, double extent, CounterRandom& random) {
  std::vector<double> pose(static_cast<std::size_t>(PoseSize(graph.space)));
  const auto dimensions = static_cast<std::size_t>(Dimensions(graph));
  // A coordinate that is uniform between -h and h has the variance h^2 / 3.
  const double half_side = extent * std::sqrt(3.0 / Dimensions(graph));
  for (std::size_t k = 0; k < dimensions; ++k) pose[k] = half_side * (2 * random.Uniform() - 1);
  if (dimensions == 2) {
    pose[2] = std::numbers::pi * (2 * random.Uniform() - 1);
    return pose;
  }
  double square = 0;
  for (std::size_t k = 3; k < 7; ++k) {
    pose[k] = random.Normal();
    square += pose[k] * pose[k];
  }
  for (std::size_t k = 3; k < 7; ++k) pose[k] /= std::sqrt(square);
  return pose;
}

}  // namespace

double PositionDifference(const PoseGraph& graph, const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); i += static_cast<std::size_t>(PoseSize(graph.space))) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(Dimensions(graph)); ++k)
      sum += std::pow(a[i + k] - b[i + k], 2);
  }
  return std::sqrt(sum / static_cast<double>(graph.num_poses()));
}

PoseGraph WithWrongClosures(PoseGraph graph, const WrongClosures& options) {
  std::vector<Index> closures;
  for (Index e = 0; e < graph.num_edges(); ++e) {
    if (!IsOdometry(graph, e)) closures.push_back(e);
  }
  VESTA_CHECK(!closures.empty() && graph.num_poses() > 2, "a graph without closures");
  const double extent = options.size * PositionExtent(graph, graph.poses);
  const auto count = std::llround(options.fraction * static_cast<double>(closures.size()));
  const Index size = InformationSize(graph.space);
  for (long long i = 0; i < count; ++i) {
    CounterRandom random(options.seed, static_cast<std::uint64_t>(i));
    const Index source = closures[static_cast<std::size_t>(random.Below(std::ssize(closures)))];
    PoseGraph::Edge edge;
    do {
      edge = {random.Below(graph.num_poses()), random.Below(graph.num_poses())};
    } while (std::abs(edge.from - edge.to) < 2);
    graph.edges.push_back(edge);
    const std::vector<double> pose = RandomPose(graph, extent, random);
    graph.measurements.insert(graph.measurements.end(), pose.begin(), pose.end());
    const std::vector<double> information(graph.information.begin() + source * size,
                                          graph.information.begin() + (source + 1) * size);
    graph.information.insert(graph.information.end(), information.begin(), information.end());
  }
  return graph;
}

}  // namespace vesta::bench
