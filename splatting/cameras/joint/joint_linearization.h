// SPDX-License-Identifier: Apache-2.0
// The linearization of the joint problem of splats and cameras at one x, and its damped system with the views' unknowns
// eliminated.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "solver/reduced_system.h"
#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/cameras/joint/joint_problem.h"

namespace vesta::gs {

// One view.
template <class B>
struct JointUnit {
  const TargetView<B>* target = nullptr;
  ViewUnknowns unknowns;
  typename SplatBackend<B>::SplatView view;
  typename B::Vector rendered;  // before the exposure
  typename SplatBackend<B>::Loss::Linearization W;
  std::vector<double> prior, prior_jacobian;  // ViewPrior's
  // J_c^T W J_c of the view's own unknowns, the prior's included; made when it is asked for. W J_c: only where views
  // may be eliminated.
  std::vector<double> curvature;
  ViewColumns<B> weighted;

  Index values() const { return rendered.size(); }
};

template <Backend B>
class JointLinearization final : public Linearization<B>,
                                 public WithLossWeights<B>,
                                 public WithProductH<B>,
                                 public WithBlocks<B>,
                                 public WithReducedSystem<B>,
                                 public WithOwnRightHandSide<B> {
 public:
  using S = typename B::Scalar;
  using typename Linearization<B>::ConstVectorView;
  using typename Linearization<B>::VectorView;

  // scratch is shared with the problem.
  JointLinearization(const JointProblemOptions& options, const JointLayout& layout, ConstVectorView x,
                     std::span<const TargetView<B>> views, std::shared_ptr<JointScratch<B>> scratch);

  // Residuals are the colour differences e = shown - truth, view after view, each 3 planes; then for each view those of
  // the prior.
  Index num_residuals() const override { return num_values_ + num_priors(); }
  Index num_parameters() const override { return layout_.num_tangent(); }
  ConstVectorView residuals() const override;
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  // The identity on the prior's.
  void ApplyW(ConstVectorView u, VectorView Wu) override;
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  void Gradient(VectorView g) override;
  // The gradient; that of the splats shrunk where the views disagree (lm/gradient_shrinkage.h).
  bool has_own_right_hand_side() const override { return options_.splats.gradient_shrinkage > 0; }
  void RightHandSide(VectorView d) override;
  // Exact for views; for splats exact for W's pointwise part, which stands in for W (docs/mathematics.md).
  void DiagJTJ(VectorView d) override;
  std::vector<BlockGroup> block_groups() const override { return BlockGroupsOf(options_, layout_); }
  void BlockGram(BlockDiagonal<B>& blocks) override;
  // Null unless the options have it.
  std::unique_ptr<ReducedSystem<B>> MakeReducedSystem() override;

  // The parts that the reduced system is made of.
  const JointLayout& layout() const { return layout_; }
  const std::vector<JointUnit<B>>& units() const { return units_; }
  // Steps and gradients of one view are those of the splats, where they lie, and the rest (ConstRest).
  using ConstHere = HostSpan<const S>;
  using Here = HostSpan<S>;
  // d_image = J of view v by the splats; g += its transpose times u, an image, which is overwritten.
  void ApplySplatsJ(Index v, ConstVectorView splats, VectorView d_image);
  void AddSplatsJT(Index v, VectorView u, VectorView g);
  void ApplyW(const JointUnit<B>& unit, ConstVectorView u, VectorView Wu) { scratch_->loss.ApplyW(unit.W, u, Wu); }
  // What both hold of the diagonal and the blocks.
  const SplatGrams<B>& Grams();
  const std::vector<double>& CurvatureOf(std::size_t view) { return MakeCurvature(units_[view]); }
  JointScratch<B>& scratch() { return *scratch_; }

 private:
  static constexpr Index kGrain = 16384;  // parameters

  Index num_priors() const { return layout_.views * layout_.free.num_tangent(); }
  // Builds all views, and sums their gradients, of which comes the descent.
  void MakeUnits();
  // x: the rest of it.
  void Build(Index v, ConstHere x, JointUnit<B>& unit, VectorView image_gradient);
  // d_image = J v of view v, without the prior's; g += J^T u, u overwritten.
  void ApplyViewJ(Index v, ConstVectorView splats, ConstHere rest, VectorView d_image);
  void AddViewJT(Index v, VectorView u, VectorView g, Here g_rest);
  // out = J_p v and g += J_p^T u of the prior of view v, which is on the rest alone.
  void ApplyPriorJ(Index v, ConstHere step, S* out) const;
  void AddPriorJT(Index v, const S* u, Here g) const;
  const std::vector<double>& MakeCurvature(JointUnit<B>& unit);

  JointProblemOptions options_;
  JointLayout layout_;
  ConstVectorView x_;
  splat::Model<S> model_;
  std::span<const TargetView<B>> views_;
  std::vector<JointUnit<B>> units_;
  Index num_values_ = 0;
  std::shared_ptr<JointScratch<B>> scratch_;
  typename B::Vector gradient_, rhs_;  // the second: the splats', where it is its own
  SplatGrams<B> grams_;
  mutable typename B::Vector residuals_;
};

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
