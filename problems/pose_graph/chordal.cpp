// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/chordal.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "kernels/core/parallel.h"
#include "problems/pose_graph/pose_graph_linearization.h"
#include "problems/pose_graph/pose_rotation.h"
#include "solver/internal/sparse_cholesky/factored_matrix.h"

namespace vesta::pose_graph {
namespace {

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

// Harmonic mean of the eigenvalues of the n x n block from row `first` on; 0 if it is singular. upper: the upper
// triangle of the information matrix, row by row.
double HarmonicMean(const double* upper, int size, int first, int n) {
  Eigen::Matrix3d block = Eigen::Matrix3d::Identity();
  for (int row = 0, at = 0; row < size; ++row) {
    for (int col = row; col < size; ++col, ++at) {
      const int r = row - first, c = col - first;
      if (r >= 0 && c < n) block(r, c) = block(c, r) = upper[at];
    }
  }
  const Eigen::Matrix3d inverse = block.inverse();
  const double trace = inverse.trace() - (3 - n);
  return std::isfinite(trace) && trace > 0 ? n / trace : 0;
}

Index Root(std::vector<Index>& parent, Index i) {
  while (parent[At(i)] != i) i = parent[At(i)] = parent[At(parent[At(i)])];
  return i;
}

// Minimises the sum over the edges of w |X_b - M^T X_a - t|^2, with M and t of each edge, over N x N matrices M and N x
// K matrices X of each pose; held poses keep theirs. (A pose's X_b = M^T X_a is R_b^T = R_m^T R_a^T for rotations.)
template <int N, int K>
class LinearPoses {
 public:
  using Block = Eigen::Matrix<double, N, N, Eigen::RowMajor>;
  using Value = Eigen::Matrix<double, N, K, Eigen::RowMajor>;

  LinearPoses(const PoseGraph& graph, const std::vector<bool>& held) : graph_(graph), row_of_pose_(held.size(), -1) {
    for (std::size_t i = 0; i < held.size(); ++i) {
      if (!held[i]) row_of_pose_[i] = rows_++;
    }
    std::vector<BlockPattern::Pair> pairs;
    for (const PoseGraph::Edge& edge : graph.edges) {
      const Index a = Row(edge.from), b = Row(edge.to);
      if (a >= 0 && b >= 0) pairs.push_back({a, b});
    }
    pattern_ = std::make_shared<BlockPattern>(std::vector<int>(At(rows_), N), pairs);
  }

  // edge(e) returns {w, M, t}. values: X of each pose; those of held poses are given, the others are set. planned: as
  // in ChordalPoses. False if the factor is too large.
  template <class EdgeOf>
  bool Solve(const EdgeOf& edge, double max_bytes, const PlannedPattern* planned, std::vector<Value>& values) {
    if (rows_ == 0) return true;
    std::shared_ptr<SparseCholesky> cholesky;
    if (planned && planned->cholesky) cholesky = planned->cholesky->ForPattern(*planned->pattern, *pattern_);
    if (!cholesky) cholesky = SparseCholesky::Plan(*pattern_, max_bytes);
    if (!cholesky) return false;
    FactoredMatrix factored(pattern_, *cholesky);
    std::vector<Value> right(At(rows_), Value::Zero());
    std::size_t pair = 0;
    for (Index e = 0; e < graph_.num_edges(); ++e) {
      const auto [from, to] = graph_.edges[At(e)];
      const auto [w, M, t] = edge(e);
      const Index a = Row(from), b = Row(to);
      const Block coupling = -w * M.transpose();  // of row b and column a
      if (a >= 0) {
        Diagonal(factored, a) += w * M * M.transpose();
        right[At(a)] -= w * M * t;
        if (b < 0) right[At(a)] -= coupling.transpose() * values[At(to)];
      }
      if (b >= 0) {
        Diagonal(factored, b) += w * Block::Identity();
        right[At(b)] += w * t;
        if (a < 0) right[At(b)] -= coupling * values[At(from)];
      }
      if (a >= 0 && b >= 0) {
        const Index block = pattern_->block_of_pair()[pair++];
        Eigen::Map<Block> entries(factored.matrix().block(block));
        if (b > a) {
          entries += coupling;
        } else {
          entries += coupling.transpose();
        }
      }
    }
    factored.Factorize();
    HostBuffer<double> column(rows_ * N);
    for (int k = 0; k < K; ++k) {
      for (Index i = 0; i < rows_ * N; ++i) column[i] = right[At(i / N)](i % N, k);
      factored.Apply(column, column.view());
      for (std::size_t pose = 0; pose < row_of_pose_.size(); ++pose) {
        if (row_of_pose_[pose] < 0) continue;
        for (int n = 0; n < N; ++n) values[pose](n, k) = column[row_of_pose_[pose] * N + n];
      }
    }
    return true;
  }

 private:
  Index Row(Index pose) const { return row_of_pose_[At(pose)]; }
  static Eigen::Map<Block> Diagonal(FactoredMatrix& factored, Index row) {
    return Eigen::Map<Block>(factored.matrix().diagonal(row));
  }

  const PoseGraph& graph_;
  Index rows_ = 0;
  std::vector<Index> row_of_pose_;
  std::shared_ptr<const BlockPattern> pattern_;
};

// HeldPoses of the graph that has only the edges e with uses(e).
template <class Uses>
std::vector<bool> HeldPosesOf(const PoseGraph& graph, const Uses& uses) {
  std::vector<bool> held(At(graph.num_poses()), false), has_fixed(held);
  std::vector<Index> parent(held.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  for (Index e = 0; e < graph.num_edges(); ++e) {
    const PoseGraph::Edge& edge = graph.edges[At(e)];
    if (uses(e)) parent[At(Root(parent, edge.to))] = Root(parent, edge.from);
  }
  for (const Index i : graph.fixed) held[At(i)] = has_fixed[At(Root(parent, i))] = true;
  for (Index i = 0; i < graph.num_poses(); ++i) {
    const std::size_t root = At(Root(parent, i));
    if (!has_fixed[root]) held[At(i)] = has_fixed[root] = true;
  }
  return held;
}

template <int D>
std::optional<std::vector<double>> Chordal(const PoseGraph& graph, double max_bytes, const PlannedPattern* planned) {
  const int size = PoseSize(graph.space);
  std::vector<double> poses = graph.poses;
  std::vector<IsotropicWeights> weights;
  for (Index e = 0; e < graph.num_edges(); ++e) weights.push_back(IsotropicWeightsOf(graph, e));
  const auto measurement = [&](Index e) { return graph.measurements.data() + e * size; };

  using Rotations = LinearPoses<D, D>;
  std::vector<typename Rotations::Value> transposed(At(graph.num_poses()));  // of the rotations
  for (Index i = 0; i < graph.num_poses(); ++i) transposed[At(i)] = RotationOf<D>(poses.data() + i * size).transpose();
  struct RotationEdge {
    double w;
    Rotation<D> M;
    typename Rotations::Value t;
  };
  const auto rotation_edge = [&](Index e) {
    return RotationEdge{weights[At(e)].rotation, RotationOf<D>(measurement(e)), Rotations::Value::Zero()};
  };
  // Edges without information about the rotation, such as measurements of landmarks, do not connect rotations.
  const std::vector<bool> held_rotations = HeldPosesOf(graph, [&](Index e) { return weights[At(e)].rotation > 0; });
  if (!Rotations(graph, held_rotations).Solve(rotation_edge, max_bytes, planned, transposed)) return std::nullopt;
  std::vector<Rotation<D>> rotations(transposed.size());
  ParallelFor(graph.num_poses(), 64,
              [&](Index i) { rotations[At(i)] = NearestRotation<D>(transposed[At(i)].transpose()); });

  using Positions = LinearPoses<1, D>;
  std::vector<typename Positions::Value> positions(At(graph.num_poses()));
  for (Index i = 0; i < graph.num_poses(); ++i) {
    for (int k = 0; k < D; ++k) positions[At(i)](k) = poses[At(i * size + k)];
  }
  struct PositionEdge {
    double w;
    typename Positions::Block M;
    typename Positions::Value t;
  };
  const auto position_edge = [&](Index e) {
    const Eigen::Map<const Eigen::Matrix<double, D, 1>> moved(measurement(e));
    return PositionEdge{weights[At(e)].translation, Positions::Block::Identity(),
                        (rotations[At(graph.edges[At(e)].from)] * moved).transpose()};
  };
  const std::vector<bool> held = HeldPoses(graph);
  if (!Positions(graph, held).Solve(position_edge, max_bytes, planned, positions)) return std::nullopt;

  for (Index i = 0; i < graph.num_poses(); ++i) {
    if (held[At(i)]) continue;
    double* pose = poses.data() + i * size;
    for (int k = 0; k < D; ++k) pose[k] = positions[At(i)](k);
    SetRotation<D>(rotations[At(i)], pose);
  }
  return poses;
}

}  // namespace

IsotropicWeights IsotropicWeightsOf(const PoseGraph& graph, Index edge) {
  const double* information = graph.information.data() + edge * InformationSize(graph.space);
  if (graph.space == PoseSpace::kSe2) return {std::max(information[5], 0.0) / 2, HarmonicMean(information, 3, 0, 2)};
  return {HarmonicMean(information, 6, 3, 3) / 2, HarmonicMean(information, 6, 0, 3)};
}

std::vector<bool> HeldPoses(const PoseGraph& graph) {
  return HeldPosesOf(graph, [](Index) { return true; });
}

std::optional<std::vector<double>> ChordalPoses(const PoseGraph& graph, double max_factor_gib,
                                                const PlannedPattern* planned) {
  const double max_bytes = max_factor_gib * 0x1p30;
  return graph.space == PoseSpace::kSe2 ? Chordal<2>(graph, max_bytes, planned) : Chordal<3>(graph, max_bytes, planned);
}

}  // namespace vesta::pose_graph
