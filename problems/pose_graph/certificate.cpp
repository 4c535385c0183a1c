// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/certificate.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "kernels/core/check.h"
#include "problems/pose_graph/chordal.h"
#include "problems/pose_graph/pose_rotation.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"

namespace vesta::pose_graph {
namespace {

// The matrix S with a row of blocks per pose: its position, then its rotation. The position of one pose is left out,
// because moving all poses together does not change the cost.
template <int D>
class DualMatrix {
 public:
  DualMatrix(const PoseGraph& graph, const std::vector<double>& poses, Index without_position)
      : graph_(graph), without_position_(without_position) {
    std::vector<int> sizes(static_cast<std::size_t>(graph.num_poses()), D + 1);
    sizes[static_cast<std::size_t>(without_position)] = D;
    std::vector<BlockPattern::Pair> pairs;
    for (const PoseGraph::Edge& edge : graph.edges) pairs.push_back({edge.from, edge.to});
    pattern_ = std::make_shared<BlockPattern>(sizes, pairs);
    matrix_ = std::make_unique<BlockMatrix>(pattern_);
    for (Index i = 0; i < graph.num_poses(); ++i) {
      const double* pose = poses.data() + i * PoseSize(graph.space);
      rotations_.push_back(RotationOf<D>(pose));
      positions_.emplace_back(Eigen::Map<const Vector>(pose));
    }
    multipliers_.assign(rotations_.size(), Rotation<D>::Zero());
    for (Index e = 0; e < graph.num_edges(); ++e) AddEdge(e);
    for (Index i = 0; i < graph.num_poses(); ++i) SubtractMultiplier(i);
  }

  double cost() const { return cost_; }
  double trace() const { return trace_; }
  Index num_rotation_scalars() const { return D * graph_.num_poses(); }
  double LargestDiagonal() const {
    double largest = 0;
    for (Index i = 0; i < graph_.num_poses(); ++i) {
      for (int k = 0; k < Size(i); ++k) largest = std::max(largest, matrix_->diagonal(i)[k * (Size(i) + 1)]);
    }
    return largest;
  }

  // The least eta >= first of a geometric sequence for which S + eta I (on the rotations) is positive definite;
  // infinity if there is none. Throws Error if the factor is too large.
  double LeastShift(double first, double max_bytes) const {
    // Without information, or with infinite one, there is no such sequence.
    const double last = 4 * LargestDiagonal();
    if (!(first > 0) || !std::isfinite(last)) return std::numeric_limits<double>::infinity();
    const std::shared_ptr<SparseCholesky> cholesky = SparseCholesky::Plan(*pattern_, max_bytes);
    if (!cholesky)
      Fail(kOutOfMemory, "pose graph: the factor for the certificate exceeds {:.3g} GiB", max_bytes / 0x1p30);
    HostBuffer<double> on_rotations(pattern_->num_scalars());
    for (Index i = 0; i < graph_.num_poses(); ++i) {
      for (int k = Size(i) - D; k < Size(i); ++k) on_rotations[pattern_->offset(i) + k] = 1;
    }
    const std::shared_ptr<BlockCholesky> factor = cholesky->Factor();
    constexpr double kRatio = 4;
    for (double shift = first; shift <= last; shift *= kRatio) {
      if (factor->Factorize(*matrix_, shift, on_rotations) == 0) return shift;
    }
    return std::numeric_limits<double>::infinity();
  }

 private:
  static constexpr int kRow = D + 1, kEdge = 2 * kRow;
  using Vector = Eigen::Matrix<double, D, 1>;

  int Size(Index pose) const { return pose == without_position_ ? D : kRow; }

  // The terms of an edge: w |y v|^2 for each row y of [p_a R_a p_b R_b].
  void AddEdge(Index e) {
    const std::size_t a = static_cast<std::size_t>(graph_.edges[static_cast<std::size_t>(e)].from),
                      b = static_cast<std::size_t>(graph_.edges[static_cast<std::size_t>(e)].to);
    const double* measurement = graph_.measurements.data() + e * PoseSize(graph_.space);
    const IsotropicWeights w = IsotropicWeightsOf(graph_, e);
    const Rotation<D> turn = RotationOf<D>(measurement);
    const Eigen::Map<const Vector> moved(measurement);
    Eigen::Matrix<double, kEdge, 1> of_position = Eigen::Matrix<double, kEdge, 1>::Zero();
    of_position(0) = -1, of_position(kRow) = 1;
    of_position.template segment<D>(1) = -moved;
    Eigen::Matrix<double, kEdge, D> of_rotation = Eigen::Matrix<double, kEdge, D>::Zero();
    of_rotation.template block<D, D>(1, 0) = -turn;
    of_rotation.template block<D, D>(kRow + 1, 0).setIdentity();
    const Eigen::Matrix<double, kEdge, kEdge> terms =
        w.translation * of_position * of_position.transpose() + w.rotation * of_rotation * of_rotation.transpose();

    const Vector position_error = positions_[b] - positions_[a] - rotations_[a] * moved;
    const Rotation<D> rotation_error = rotations_[b] - rotations_[a] * turn;
    multipliers_[a] -=
        w.translation * position_error * moved.transpose() + w.rotation * rotation_error * turn.transpose();
    multipliers_[b] += w.rotation * rotation_error;
    cost_ += 0.5 * (w.translation * position_error.squaredNorm() + w.rotation * rotation_error.squaredNorm());
    Add(terms.template topLeftCorner<kRow, kRow>(), static_cast<Index>(a), static_cast<Index>(a),
        matrix_->diagonal(static_cast<Index>(a)));
    Add(terms.template bottomRightCorner<kRow, kRow>(), static_cast<Index>(b), static_cast<Index>(b),
        matrix_->diagonal(static_cast<Index>(b)));
    double* block = matrix_->block(pattern_->block_of_pair()[static_cast<std::size_t>(e)]);
    if (b > a) {
      Add(terms.template bottomLeftCorner<kRow, kRow>(), static_cast<Index>(b), static_cast<Index>(a), block);
    } else {
      Add(terms.template topRightCorner<kRow, kRow>(), static_cast<Index>(a), static_cast<Index>(b), block);
    }
  }
  // Adds to a block of the matrix, without the row and column of a position that is left out.
  template <class Terms>
  void Add(const Terms& terms, Index row, Index col, double* block) const {
    const int rows = Size(row), cols = Size(col);
    for (int i = 0; i < rows; ++i) {
      for (int k = 0; k < cols; ++k) block[i * cols + k] += terms(i + kRow - rows, k + kRow - cols);
    }
  }
  // Lambda of one pose: the symmetric part of R^T (Y M) in the columns of its rotation.
  void SubtractMultiplier(Index i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const Rotation<D> product = rotations_[at].transpose() * multipliers_[at];
    Eigen::Matrix<double, kRow, kRow> lambda = Eigen::Matrix<double, kRow, kRow>::Zero();
    lambda.template bottomRightCorner<D, D>() = -0.5 * (product + product.transpose());
    trace_ += product.trace();
    Add(lambda, i, i, matrix_->diagonal(i));
  }

  const PoseGraph& graph_;
  Index without_position_;
  std::shared_ptr<const BlockPattern> pattern_;
  std::unique_ptr<BlockMatrix> matrix_;
  std::vector<Rotation<D>> rotations_, multipliers_;
  std::vector<Vector> positions_;
  double cost_ = 0, trace_ = 0;
};

template <int D>
Certificate CertifyIn(const PoseGraph& graph, const std::vector<double>& poses, Index first, double max_bytes) {
  const DualMatrix<D> dual(graph, poses, first);
  const auto scalars = static_cast<double>(dual.num_rotation_scalars());
  // A millionth of the cost in all, but above the rounding errors of the factor.
  const double least = std::max(2e-6 * dual.cost() / scalars, 2e-13 * dual.LargestDiagonal());
  const double shift = dual.LeastShift(least, max_bytes);
  const double bound = 0.5 * (dual.trace() - shift * scalars);
  return {dual.cost(), std::isfinite(bound) ? std::clamp(bound, 0.0, dual.cost()) : 0.0};
}

}  // namespace

double Certificate::gap() const { return cost > 0 ? (cost - lower_bound) / cost : 0; }

Certificate Certify(const PoseGraph& graph, const std::vector<double>& poses, double max_factor_gib) {
  VESTA_CHECK(poses.size() == graph.poses.size(), "{} values of poses for a graph with {}", poses.size(),
              graph.poses.size());
  if (!graph.landmarks.empty()) Fail(kUnsupported, "pose graph: a certificate needs a graph without landmarks");
  const std::vector<bool> held = HeldPoses(graph);
  const auto first = std::find(held.begin(), held.end(), true);
  if (first == held.end()) Fail(kBadArgument, "pose graph: there are no poses to certify");
  if (std::count(held.begin(), held.end(), true) > 1) {
    Fail(kUnsupported, "pose graph: a certificate needs a connected graph with at most one fixed pose");
  }
  const double max_bytes = max_factor_gib * 0x1p30;
  return graph.space == PoseSpace::kSe2 ? CertifyIn<2>(graph, poses, first - held.begin(), max_bytes)
                                        : CertifyIn<3>(graph, poses, first - held.begin(), max_bytes);
}

}  // namespace vesta::pose_graph
