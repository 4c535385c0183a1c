// SPDX-License-Identifier: Apache-2.0
// Linearization of the joint problem of Gaussians ("splats") and cameras, and its reduced system, from which the views'
// unknowns are eliminated. J_s and J_c are the derivatives of a view's image with respect to the Gaussians and the
// view's own unknowns; W is the curvature of the photometric loss.
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

// Data of one view.
template <class B>
struct JointUnit {
  const TargetView<B>* target = nullptr;
  ViewUnknowns unknowns;
  typename SplatBackend<B>::SplatView view;
  typename B::Vector rendered;  // before the exposure
  typename SplatBackend<B>::Loss::Linearization W;
  std::vector<double> prior, prior_jacobian;  // residuals and Jacobian of ViewPrior
  // curvature: J_c^T W J_c plus the prior's curvature, row-major, computed on first use. weighted: W J_c, only if views
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

  // Shares `scratch` with the problem.
  JointLinearization(const JointProblemOptions& options, const JointLayout& layout, ConstVectorView x,
                     std::span<const TargetView<B>> views, std::shared_ptr<JointScratch<B>> scratch);

  // Residuals: colour differences e = exposed image - photograph of all views, 3 planes each; then the prior residuals
  // of all views.
  Index num_residuals() const override { return num_values_ + num_priors(); }
  Index num_parameters() const override { return layout_.num_tangent(); }
  ConstVectorView residuals() const override;
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  // W is the identity for prior residuals.
  void ApplyW(ConstVectorView u, VectorView Wu) override;
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  void Gradient(VectorView g) override;
  // The negative gradient, shrunk for the Gaussians (lm/gradient_shrinkage.h).
  bool has_own_right_hand_side() const override { return options_.splats.gradient_shrinkage > 0; }
  void RightHandSide(VectorView d) override;
  // Exact for the views' unknowns. For Gaussians, W is replaced by its pointwise part (docs/mathematics.md).
  void DiagJTJ(VectorView d) override;
  std::vector<BlockGroup> block_groups() const override { return BlockGroupsOf(options_, layout_); }
  void BlockGram(BlockDiagonal<B>& blocks) override;
  // Null unless options.eliminate_views.
  std::unique_ptr<ReducedSystem<B>> MakeReducedSystem() override;

  // Building blocks of the reduced system.
  const JointLayout& layout() const { return layout_; }
  const std::vector<JointUnit<B>>& units() const { return units_; }
  // Steps and gradients are passed in two parts: the Gaussians, in the memory of B, and the rest on the host
  // (joint_layout.h).
  using ConstHere = HostSpan<const S>;
  using Here = HostSpan<S>;
  // ApplySplatsJ: d_image = J_s * splats for view v. AddSplatsJT: g += J_s^T u; overwrites the image u.
  void ApplySplatsJ(Index v, ConstVectorView splats, VectorView d_image);
  void AddSplatsJT(Index v, VectorView u, VectorView g);
  void ApplyW(const JointUnit<B>& unit, ConstVectorView u, VectorView Wu) { scratch_->loss.ApplyW(unit.W, u, Wu); }
  // Diagonal and blocks of J_s^T W J_s, computed on first use.
  const SplatGrams<B>& Grams();
  const std::vector<double>& CurvatureOf(std::size_t view) { return MakeCurvature(units_[view]); }
  JointScratch<B>& scratch() { return *scratch_; }

 private:
  static constexpr Index kGrain = 16384;  // parameters

  Index num_priors() const { return layout_.views * layout_.free.num_tangent(); }
  // Builds all views, sums their gradients and computes the right-hand side.
  void BuildViews();
  // x: the rest of the parameter vector. image_gradient: receives the gradient of the view's cost with respect to its
  // rendered image.
  void Build(Index v, ConstHere x, JointUnit<B>& unit, VectorView image_gradient);
  // ApplyViewJ: d_image = J_s * splats + J_c * (its part of rest) for view v, without the prior. AddViewJT: adds J_s^T
  // u to g and J_c^T u to g_rest; overwrites u.
  void ApplyViewJ(Index v, ConstVectorView splats, ConstHere rest, VectorView d_image);
  void AddViewJT(Index v, VectorView u, VectorView g, Here g_rest);
  // out = J_p step and g += J_p^T u, with the Jacobian J_p of the prior of view v, which depends on the rest alone.
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
  typename B::Vector gradient_, rhs_;  // rhs_: part of the Gaussians, if gradient shrinkage is on
  SplatGrams<B> grams_;
  mutable typename B::Vector residuals_;
};

// The damped system with the views' unknowns eliminated. Only a view's own image couples its unknowns with the
// Gaussians. So the Schur complement is lambda D plus the sum over views of J_s^T (W - W J_c C^-1 J_c^T W) J_s. C =
// J_c^T W J_c + prior + lambda D is the damped system of the view's own unknowns; D is the damping metric. W J_c is
// stored: up to eight images per view.
template <Backend B>
class JointReducedSystem final : public ReducedSystem<B> {
 public:
  using typename ReducedSystem<B>::ConstVectorView;
  using typename ReducedSystem<B>::VectorView;

  // Refers to the linearization.
  explicit JointReducedSystem(JointLinearization<B>& linearization);

  Index size() const override { return layout_.splats; }
  void SetDamping(double lambda, ConstVectorView metric) override;
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override;
  void Apply(ConstVectorView x, VectorView y) override;
  void BackSubstitute(ConstVectorView rhs, VectorView step) override;
  // The blocks of J_s^T W J_s. They are upper bounds of the Schur complement's blocks; computing the latter would need
  // six adjoint passes per view.
  std::vector<BlockGroup> kept_groups() const override;
  void DiagonalBlocks(BlockDiagonal<B>& diagonal) override;

 private:
  HostSpan<double> ViewPart(std::size_t view) {
    const Index n = layout_.free.num_tangent();
    return views_.view().subspan(static_cast<Index>(view) * n, n);
  }
  // Multiplies this view's numbers in views_ by C^-1.
  void SolveView(std::size_t view) { blocks_[view].Solve(ViewPart(view), ViewPart(view)); }

  JointLinearization<B>& linearization_;
  const JointLayout& layout_;
  double lambda_ = 0;
  ConstVectorView metric_;                                 // part of the Gaussians
  std::vector<BlockDiagonal<CpuBackend<double>>> blocks_;  // factorised C for each view
  HostBuffer<double> views_;                               // workspace: the rest of a vector, all views
};

}  // namespace vesta::gs
