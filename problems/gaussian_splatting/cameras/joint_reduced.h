// The damped joint system with the views' unknowns eliminated.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/cameras/joint_linearization.h"
#include "solver/normal_equations/reduced_system.h"

namespace vesta::gs {

// The blocks of the views in a vector whose first is at `offset`, and their values.
inline BlockGroup ViewBlocks(const JointLayout& layout, Index offset) {
  const int n = layout.free.num_tangent();
  return {.size = n, .count = layout.views, .offset = offset, .component_stride = 1, .block_stride = n};
}
template <class S, class T>
void FillViewBlocks(JointLinearization<S>& linearization, HostSpan<T> values) {
  const JointLayout& layout = linearization.layout();
  const Index n = layout.free.num_tangent();
  for (Index v = 0; v < layout.views; ++v) {
    const std::vector<double>& H = linearization.CurvatureOf(static_cast<std::size_t>(v));
    for (int row = 0; row < n; ++row) {
      for (int col = 0; col <= row; ++col) {
        values[PackedLower(row, col) * layout.views + v] = static_cast<T>(H[static_cast<std::size_t>(row * n + col)]);
      }
    }
  }
}

// A view's unknowns meet the splats in its own image alone. So the Schur complement is the sum over views of
// J_s^T (W - W J_c C^-1 J_c^T W) J_s, C = J_c^T W J_c + lambda D of the view: products as those of the splats alone,
// with what a camera could do taken out of each image. W J_c is held, eight images a view.
template <class S>
class JointReducedSystem final : public ReducedSystem<CpuBackend<S>> {
 public:
  using B = CpuBackend<S>;
  using typename ReducedSystem<B>::ConstView;
  using typename ReducedSystem<B>::View;

  // Borrows the linearization.
  explicit JointReducedSystem(JointLinearization<S>& linearization);

  Index size() const override { return layout_.splats; }
  void SetDamping(double lambda, ConstView metric) override;
  void ReduceRhs(ConstView rhs, View reduced) override;
  void Apply(ConstView x, View y) override;
  void BackSubstitute(ConstView rhs, View step) override;
  // Of the splats. Their blocks are those of H: upper bounds of the Schur complement's, which would take six adjoint
  // passes a view.
  std::vector<BlockGroup> kept_groups() const override;
  void DiagonalBlocks(BlockDiagonal<B>& diagonal) override;

 private:
  // all[views * num_tangent] = C^-1 all.
  void SolveViews(HostBuffer<double>& all) const { blocks_.Solve(all, all); }
  Index At(std::size_t view) const { return static_cast<Index>(view) * layout_.free.num_tangent(); }

  JointLinearization<S>& linearization_;
  const JointLayout& layout_;
  double lambda_ = 0;
  ConstView metric_;
  BlockDiagonal<CpuBackend<double>> blocks_;  // C, its factor
  HostBuffer<double> views_;
  HostBuffer<S> image_, weighted_;
};

}  // namespace vesta::gs
