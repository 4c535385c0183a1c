// SPDX-License-Identifier: Apache-2.0
// A pose graph at one x: residuals, Jacobian blocks of the edges, and H = J^T J as a sparse matrix.
#pragma once

#include <vector>

#include "problems/pose_graph/pose_graph_layout.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "solver/problem_interfaces.h"

namespace vesta::pose_graph {

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
  // One block for each pose that moves.
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
  HostBuffer<double> jacobian_;  // row-major tangent() x 2 tangent() for each edge
  BlockMatrix hessian_;
};

}  // namespace vesta::pose_graph
