// SPDX-License-Identifier: Apache-2.0
// The damped joint system with the views' unknowns eliminated.
#pragma once

#include <vector>

#include "solver/reduced_system.h"
#include "splatting/cameras/joint/joint_linearization.h"

namespace vesta::gs {

// A view's unknowns meet the splats in its own image alone. So the Schur complement is the sum over views of
// J_s^T (W - W J_c C^-1 J_c^T W) J_s, C = J_c^T W J_c + lambda D of the view: products as those of the splats alone,
// with what a camera could do taken out of each image. W J_c is held, eight images a view.
template <Backend B>
class JointReducedSystem final : public ReducedSystem<B> {
 public:
  using typename ReducedSystem<B>::ConstVectorView;
  using typename ReducedSystem<B>::VectorView;

  // Borrows the linearization.
  explicit JointReducedSystem(JointLinearization<B>& linearization);

  Index size() const override { return layout_.splats; }
  void SetDamping(double lambda, ConstVectorView metric) override;
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override;
  void Apply(ConstVectorView x, VectorView y) override;
  void BackSubstitute(ConstVectorView rhs, VectorView step) override;
  // Those of H: upper bounds of the Schur complement's, which would take six adjoint passes a view.
  std::vector<BlockGroup> kept_groups() const override;
  void DiagonalBlocks(BlockDiagonal<B>& diagonal) override;

 private:
  HostSpan<double> ViewPart(std::size_t view) {
    const Index n = layout_.free.num_tangent();
    return views_.view().subspan(static_cast<Index>(view) * n, n);
  }
  // In place by C^-1 of that view.
  void SolveView(std::size_t view) { blocks_[view].Solve(ViewPart(view), ViewPart(view)); }

  JointLinearization<B>& linearization_;
  const JointLayout& layout_;
  double lambda_ = 0;
  ConstVectorView metric_;                                 // of the splats
  std::vector<BlockDiagonal<CpuBackend<double>>> blocks_;  // C of each view, its factor
  HostBuffer<double> views_;                               // of all of them
};

}  // namespace vesta::gs
