// SPDX-License-Identifier: Apache-2.0
// Linearization of a pose graph at one x: residuals, Jacobian blocks, and H = J^T J as a sparse matrix of blocks. A
// residual is whitened: multiplied by a matrix that depends on the edge's information matrix (EdgeError), so that its
// covariance is the identity.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "problems/pose_graph/pose_graph.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "solver/internal/sparse_cholesky/block_matrix.h"
#include "solver/loss.h"
#include "solver/problem_interfaces.h"

namespace vesta::pose_graph {

// The edges of a pose graph. x: the values of all poses, as in PoseGraph::poses.
struct EdgeTerms {
  PoseSpace space = PoseSpace::kSe2;
  std::vector<PoseGraph::Edge> edges;
  std::vector<double> measurements;  // as PoseGraph::measurements
  std::vector<double> whitening;     // row-major TangentSize x TangentSize per edge
  // Per edge: 1 if `to` is a landmark. Its rotation residual is then the landmark's own rotation, so that it stays the
  // identity.
  std::vector<char> to_landmark;
  std::shared_ptr<const Loss> loss;  // null: plain least squares
  // In 2D, the third residual is the chord 2 sin(yaw error / 2) instead of the yaw error. In 3D it is a chord anyway.
  bool has_chords = false;

  Index num_edges() const { return static_cast<Index>(edges.size()); }
  int tangent() const { return TangentSize(space); }

  // 1/2 rho(|whitened residual|^2) of one edge.
  double Cost(Index edge, const double* x) const;
  // Writes the whitened residual (TangentSize values) and its Jacobian with respect to the steps of poses `from` and
  // `to` (row-major, TangentSize x 2 TangentSize), both corrected for the loss (solver/loss.h).
  void Linearize(Index edge, const double* x, double* residual, double* jacobian) const;
};

// One end of an edge: side 0 is `from`, side 1 is `to`.
struct EdgeEnd {
  Index edge;
  int side;
};

// Places of poses and edges in vectors and matrices. A row is a block row of H: one pose that is not fixed.
struct PoseGraphLayout {
  EdgeTerms terms;
  std::vector<Index> row_of_pose;               // by pose; -1 for fixed poses
  std::vector<Index> pose_of_row;               // the inverse
  std::shared_ptr<const BlockPattern> pattern;  // block pattern of H
  std::vector<std::size_t> first_end;           // row r has the entries first_end[r]..first_end[r + 1] - 1 of `ends`
  std::vector<EdgeEnd> ends;                    // the edges of each row's pose, ascending
  std::vector<std::size_t> first_edge;          // likewise for edges_of_block, per block of the pattern
  std::vector<Index> edges_of_block;            // the edges that contribute to each block, ascending

  int tangent() const { return terms.tangent(); }
  // Number of entries of a step of all poses.
  Index num_tangent() const { return static_cast<Index>(pose_of_row.size()) * tangent(); }
  // -1 if the pose is fixed.
  Index Row(Index edge, int side) const {
    const PoseGraph::Edge& e = terms.edges[static_cast<std::size_t>(edge)];
    return row_of_pose[static_cast<std::size_t>(side == 0 ? e.from : e.to)];
  }
  std::span<const EdgeEnd> EndsAt(Index row) const {
    const auto r = static_cast<std::size_t>(row);
    return std::span(ends).subspan(first_end[r], first_end[r + 1] - first_end[r]);
  }
  std::span<const Index> EdgesOf(Index block) const {
    const auto b = static_cast<std::size_t>(block);
    return std::span(edges_of_block).subspan(first_edge[b], first_edge[b + 1] - first_edge[b]);
  }
};

// The pattern of H and the plan of its factor; null if the factor would be too large.
struct PlannedPattern {
  std::shared_ptr<const BlockPattern> pattern;
  std::shared_ptr<const SparseCholesky> cholesky;
};

// fixed: indices of the fixed poses.
PoseGraphLayout MakeLayout(EdgeTerms terms, Index num_poses, std::span<const Index> fixed);

class PoseGraphLinearization final : public Linearization<CpuBackend<double>>,
                                     public WithProductH<CpuBackend<double>>,
                                     public WithBlocks<CpuBackend<double>>,
                                     public NormalMatrixSource {
 public:
  using B = CpuBackend<double>;

  // layout must outlive this object.
  PoseGraphLinearization(const PoseGraphLayout& layout, ConstVectorView x);

  Index num_residuals() const override { return residuals_.size(); }
  Index num_parameters() const override { return layout_.num_tangent(); }
  ConstVectorView residuals() const override { return residuals_.view(); }
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  void DiagJTJ(VectorView d) override;
  void ApplyH(ConstVectorView v, VectorView Hv) override { hessian_.Apply(v, Hv); }
  // One block per pose that is not fixed.
  std::vector<BlockGroup> block_groups() const override;
  void BlockGram(BlockDiagonal<B>& blocks) override;

  const BlockMatrix& NormalMatrix() override { return hessian_; }

 private:
  template <int D>
  void FillHessian();
  // Row i of the Jacobian of one end of an edge, tangent() values.
  const double* JacobianRow(Index edge, int side, int i) const {
    const Index d = layout_.tangent();
    return jacobian_.data() + (edge * d + i) * 2 * d + side * d;
  }

  const PoseGraphLayout& layout_;
  HostBuffer<double> residuals_;
  HostBuffer<double> jacobian_;  // row-major tangent() x 2 tangent() per edge
  BlockMatrix hessian_;
};

}  // namespace vesta::pose_graph
