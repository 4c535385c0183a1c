// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/closure_check.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <numeric>
#include <optional>

#include "kernels/core/check.h"
#include "problems/pose_graph/chordal.h"
#include "problems/pose_graph/pose_graph_problem.h"
#include "problems/pose_graph/pose_rotation.h"

namespace vesta::pose_graph {
namespace {

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

// Probability that a chi-square variable exceeds x, by recursion from 1 or 2 degrees of freedom.
double ChiSquareTail(int degrees, double x) {
  const bool is_even = degrees % 2 == 0;
  double tail = is_even ? std::exp(-x / 2) : std::erfc(std::sqrt(x / 2));
  for (int d = is_even ? 2 : 1; d < degrees; d += 2) {
    tail += std::exp(0.5 * d * std::log(x / 2) - x / 2 - std::lgamma(0.5 * d + 1));
  }
  return tail;
}

// The extent of the poses, if the odometry is exact.
double OdometryExtent(const PoseGraph& graph) {
  std::vector<bool> kept;
  for (Index e = 0; e < graph.num_edges(); ++e) kept.push_back(IsOdometry(graph, e));
  return PositionExtent(graph, ChordalPoses(WithEdges(graph, kept)).value_or(graph.poses));
}

// A closure compared with a path between its poses: squared errors, and variances per axis.
struct Cycle {
  std::size_t num_edges = 0;
  double rotation_error = 0, position_error = 0;
  double rotation_variance = 0, position_variance = 0;
  double rotation_ratio() const { return rotation_error / rotation_variance; }
  double position_ratio() const { return position_error / position_variance; }
};

template <int D>
class CycleFinder {
 public:
  explicit CycleFinder(const PoseGraph& graph)
      : graph_(graph), neighbours_(At(graph.num_poses())), edge_to_(neighbours_.size()), visit_(neighbours_.size(), 0) {
    for (Index e = 0; e < graph.num_edges(); ++e) {
      const IsotropicWeights weights = IsotropicWeightsOf(graph, e);
      rotation_variance_.push_back(0.5 / weights.rotation);
      position_variance_.push_back(1 / weights.translation);
      // Edges without information lead nowhere.
      if (!(weights.rotation > 0 && weights.translation > 0)) continue;
      const auto [from, to] = graph.edges[At(e)];
      neighbours_[At(from)].push_back({to, e});
      neighbours_[At(to)].push_back({from, e});
    }
  }

  // The cycle of this closure and the shortest path over usable edges; nothing if there is no path.
  std::optional<Cycle> Find(Index closure, const std::vector<bool>& usable) {
    const auto [from, to] = graph_.edges[At(closure)];
    if (!FindPath(from, to, closure, usable)) return std::nullopt;
    return Compose(closure);
  }

 private:
  using Vector = Eigen::Matrix<double, D, 1>;
  struct Neighbour {
    Index pose, edge;
  };

  // Breadth-first search. Sets path_.
  bool FindPath(Index from, Index to, Index without, const std::vector<bool>& usable) {
    ++num_visits_;
    std::vector<Index> queue = {from};
    visit_[At(from)] = num_visits_;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      for (const auto [pose, edge] : neighbours_[At(queue[next])]) {
        if (visit_[At(pose)] == num_visits_ || edge == without || !usable[At(edge)]) continue;
        visit_[At(pose)] = num_visits_;
        edge_to_[At(pose)] = edge;
        if (pose != to) {
          queue.push_back(pose);
          continue;
        }
        path_.clear();
        for (Index at = to; at != from;) {
          path_.push_back(edge_to_[At(at)]);
          const PoseGraph::Edge& back = graph_.edges[At(path_.back())];
          at = back.from == at ? back.to : back.from;
        }
        std::reverse(path_.begin(), path_.end());
        return true;
      }
    }
    return false;
  }

  // The pose at the end of path_ in the frame of its start, compared with the closure.
  Cycle Compose(Index closure) {
    const int size = PoseSize(graph_.space);
    Rotation<D> rotation = Rotation<D>::Identity();
    Vector position = Vector::Zero();
    // Position of the pose `to` of each edge, about which its rotation error turns the rest.
    std::vector<Vector> pivots;
    Index at = graph_.edges[At(closure)].from;
    Cycle cycle{.num_edges = path_.size(),
                .rotation_variance = rotation_variance_[At(closure)],
                .position_variance = position_variance_[At(closure)]};
    for (const Index e : path_) {
      const double* measurement = graph_.measurements.data() + e * size;
      const Rotation<D> turn = RotationOf<D>(measurement);
      const Eigen::Map<const Vector> moved(measurement);
      const auto [from, to] = graph_.edges[At(e)];
      if (from == at) {
        position += rotation * moved;
        rotation *= turn;
        pivots.push_back(position);
      } else {
        pivots.push_back(position);
        rotation *= turn.transpose();
        position -= rotation * moved;
      }
      at = from == at ? to : from;
      cycle.rotation_variance += rotation_variance_[At(e)];
      cycle.position_variance += position_variance_[At(e)];
    }
    // A turn about each of the axes moves the end in D - 1 directions in 3D, and in one in 2D.
    constexpr double kMovedPerAxis = (D - 1.0) / D;
    for (std::size_t k = 0; k < path_.size(); ++k) {
      cycle.position_variance +=
          kMovedPerAxis * rotation_variance_[At(path_[k])] * (position - pivots[k]).squaredNorm();
    }
    const double* measurement = graph_.measurements.data() + closure * size;
    cycle.rotation_error = 0.5 * (rotation - RotationOf<D>(measurement)).squaredNorm();
    cycle.position_error = (position - Eigen::Map<const Vector>(measurement)).squaredNorm();
    return cycle;
  }

  const PoseGraph& graph_;
  std::vector<std::vector<Neighbour>> neighbours_;             // by pose
  std::vector<double> rotation_variance_, position_variance_;  // by edge
  std::vector<Index> edge_to_, visit_, path_;
  Index num_visits_ = 0;
};

// The ratio of squared errors to variances at a quantile, relative to the same quantile of the chi-square distribution.
double ScaleOf(const std::vector<Cycle>& cycles, double (Cycle::*ratio)() const, int degrees) {
  constexpr double kQuantile = 0.75;
  std::vector<double> ratios(cycles.size());
  std::ranges::transform(cycles, ratios.begin(), ratio);
  const auto at = ratios.begin() + static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(ratios.size()));
  std::nth_element(ratios.begin(), at, ratios.end());
  return *at / ChiSquareQuantile(degrees, 1 - kQuantile);
}

// Bounds of the squared errors of a cycle relative to its variances, and the chance that any closure is below them.
template <int D>
struct CycleTest {
  static constexpr int kRotation = D == 2 ? 1 : 3;

  CycleTest(const PoseGraph& graph, std::size_t num_closures, double significance, double rotation_scale,
            double position_scale)
      // A disc or ball of this radius has the same extent.
      : radius(OdometryExtent(graph) * std::sqrt((D + 2.0) / D)) {
    const double each = significance / (2 * static_cast<double>(num_closures));
    rotation_bound = rotation_scale * ChiSquareQuantile(kRotation, each);
    position_bound = position_scale * ChiSquareQuantile(D, each);
  }

  bool Passes(const Cycle& cycle) const {
    return cycle.rotation_ratio() <= rotation_bound && cycle.position_ratio() <= position_bound;
  }
  double Chance(const Cycle& cycle) const {
    const double angle = 2 * std::asin(std::min(1.0, 0.5 * std::sqrt(rotation_bound * cycle.rotation_variance)));
    const double of_rotations = (D == 2 ? angle : angle - std::sin(angle)) / std::numbers::pi;
    const double part = std::sqrt(position_bound * cycle.position_variance) / radius;
    return part < 1 ? of_rotations * std::pow(part, D) : of_rotations;
  }

  double radius, rotation_bound = 0, position_bound = 0;
};

struct Tested {
  Index edge;
  double chance;
  bool passes;
};
// Supports closures in ascending order of their chance, while the expected number of wrong ones is below `max_wrong`.
// tests: in this order. Edges without a test are supported.
std::vector<bool> Support(const std::vector<Tested>& tests, std::size_t num_edges, double max_wrong) {
  std::vector<bool> supported(num_edges, true);
  double num_wrong = 0;
  for (const auto& [edge, chance, passes] : tests) {
    if (!passes) num_wrong += chance < 1 ? chance / (1 - chance) : max_wrong;
    supported[At(edge)] = passes && num_wrong < max_wrong;
  }
  return supported;
}

// The cycles that are not longer than half of them.
std::vector<Cycle> ShorterHalf(const std::vector<std::pair<Index, Cycle>>& cycles) {
  std::vector<std::size_t> lengths(cycles.size());
  std::ranges::transform(cycles, lengths.begin(), [](const auto& of_edge) { return of_edge.second.num_edges; });
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  std::vector<Cycle> shorter;
  for (const auto& [edge, cycle] : cycles) {
    if (cycle.num_edges <= *middle) shorter.push_back(cycle);
  }
  return shorter;
}

template <int D>
ClosureCheck CheckIn(const PoseGraph& graph, double significance) {
  const auto num_edges = At(graph.num_edges());
  std::vector<Index> closures;
  for (Index e = 0; e < graph.num_edges(); ++e) {
    if (!IsOdometry(graph, e)) closures.push_back(e);
  }
  ClosureCheck check{.supported = std::vector<bool>(num_edges, true), .likely = std::vector<bool>(num_edges, true)};
  CycleFinder<D> finder(graph);
  std::vector<bool> usable(num_edges, true);
  std::optional<CycleTest<D>> test;
  std::ptrdiff_t most = -1;
  for (bool grows = !closures.empty(); grows;) {
    std::vector<std::pair<Index, Cycle>> cycles;
    for (const Index e : closures) {
      if (const std::optional<Cycle> cycle = finder.Find(e, usable)) cycles.emplace_back(e, *cycle);
    }
    if (cycles.empty()) break;
    if (!test) {
      const std::vector<Cycle> shorter = ShorterHalf(cycles);
      check.rotation_scale = ScaleOf(shorter, &Cycle::rotation_ratio, CycleTest<D>::kRotation);
      check.position_scale = ScaleOf(shorter, &Cycle::position_ratio, D);
      test.emplace(graph, closures.size(), significance, check.rotation_scale, check.position_scale);
    }
    usable.assign(num_edges, true);
    std::vector<Tested> tests;
    for (const auto& [e, cycle] : cycles) {
      usable[At(e)] = test->Passes(cycle);
      tests.push_back({e, test->Chance(cycle), usable[At(e)]});
    }
    std::stable_sort(tests.begin(), tests.end(), [](const Tested& a, const Tested& b) { return a.chance < b.chance; });
    std::vector<bool> supported = Support(tests, num_edges, 0.01);
    const auto count = std::count(supported.begin(), supported.end(), true);
    grows = count > most;
    if (!grows) break;
    most = count;
    check.supported = std::move(supported);
    check.likely = Support(tests, num_edges, 1);
  }
  return check;
}

}  // namespace

bool IsOdometry(const PoseGraph& graph, Index edge) {
  const auto [from, to] = graph.edges[At(edge)];
  return std::abs(graph.ids[At(from)] - graph.ids[At(to)]) == 1;
}

double PositionExtent(const PoseGraph& graph, const std::vector<double>& poses) {
  const Index dimensions = graph.space == PoseSpace::kSe2 ? 2 : 3;
  const Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> positions(
      poses.data(), dimensions, graph.num_poses(), Eigen::OuterStride<>(PoseSize(graph.space)));
  const Eigen::VectorXd mean = positions.rowwise().mean();
  return std::sqrt((positions.colwise() - mean).squaredNorm() / static_cast<double>(graph.num_poses()));
}

PoseGraph WithEdges(const PoseGraph& graph, const std::vector<bool>& kept) {
  VESTA_CHECK(kept.size() == graph.edges.size(), "{} values for {} edges", kept.size(), graph.edges.size());
  PoseGraph part = graph;
  part.edges.clear(), part.measurements.clear(), part.information.clear();
  const auto append = [](const std::vector<double>& from, Index edge, Index size, std::vector<double>& to) {
    to.insert(to.end(), from.begin() + edge * size, from.begin() + (edge + 1) * size);
  };
  for (Index e = 0; e < graph.num_edges(); ++e) {
    if (!kept[At(e)]) continue;
    part.edges.push_back(graph.edges[At(e)]);
    append(graph.measurements, e, PoseSize(graph.space), part.measurements);
    append(graph.information, e, InformationSize(graph.space), part.information);
  }
  return part;
}

double ChiSquareQuantile(int degrees, double probability) {
  if (degrees < 1 || !(probability > 0 && probability < 1)) {
    Fail(kBadArgument, "chi-square quantile: {} degrees of freedom and probability {}; needs >= 1, and between 0 and 1",
         degrees, probability);
  }
  double low = 0, high = degrees;
  while (ChiSquareTail(degrees, high) > probability) low = high, high *= 2;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (ChiSquareTail(degrees, middle) > probability ? low : high) = middle;
  }
  return low;
}

ClosureCheck CheckClosures(const PoseGraph& graph, double significance) {
  if (!(significance > 0 && significance < 1))
    Fail(kBadArgument, "pose graph: significance is {}; it must be between 0 and 1", significance);
  const PoseGraphProblem validated(graph);
  return graph.space == PoseSpace::kSe2 ? CheckIn<2>(graph, significance) : CheckIn<3>(graph, significance);
}

}  // namespace vesta::pose_graph
