// SPDX-License-Identifier: Apache-2.0
// Linearization of the splatting problem at one x, for one batch of views.
#pragma once

#include <memory>
#include <vector>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"

namespace vesta::gs {

template <Backend B>
class SplatLinearization final : public Linearization<B>,
                                 public WithLossWeights<B>,
                                 public WithProductH<B>,
                                 public WithBlocks<B>,
                                 public WithOwnRightHandSide<B> {
 public:
  using Base = Linearization<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;
  using S = typename B::Scalar;
  using Loss = typename SplatBackend<B>::Loss;
  using Workspace = typename SplatBackend<B>::Workspace;

  // Gradient and curvature are `scale` times the sum over the views. The problem and all its linearizations share loss
  // and workspace, one call at a time. They may also share scratch with JacobianKind::kOnTheFly, which keeps nothing in
  // it between calls; null: this linearization has its own.
  SplatLinearization(const SplatProblemOptions& options, ConstVectorView x, std::vector<const TargetView<B>*> views,
                     double scale, std::shared_ptr<Loss> loss, std::shared_ptr<Workspace> workspace,
                     std::shared_ptr<SplatScratch<B>> scratch = nullptr);

  // Residuals are the colour differences e = rendered - truth: view after view, 3 planes each.
  Index num_residuals() const override { return num_residuals_; }
  Index num_parameters() const override { return options_.Size(); }
  ConstVectorView residuals() const override;
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  void ApplyW(ConstVectorView u, VectorView Wu) override;
  // One view at a time, so that only one image is in memory.
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  void Gradient(VectorView g) override;
  // The gradient, shrunk where the views disagree (lm/gradient_shrinkage.h).
  bool has_own_right_hand_side() const override { return options_.gradient_shrinkage > 0; }
  void RightHandSide(VectorView d) override;
  void SquaredGradients(VectorView squares) override;
  void RightHandSideOf(Index units, ConstVectorView gradient, VectorView squares) const override;
  // Exact for the pointwise part of W, which replaces W here (docs/mathematics.md).
  void DiagJTJ(VectorView d) override;
  std::vector<BlockGroup> block_groups() const override;
  void BlockGram(BlockDiagonal<B>& blocks) override;
  bool blocks_give_diagonal() const override { return true; }

 private:
  using Vector = typename B::Vector;
  using Unit = typename SplatScratch<B>::Unit;
  // Builds all views and sums their gradients. Also computes the right-hand side (for a part: only the squared
  // gradients) and caches the Jacobian, depending on the options.
  void MakeUnits();
  // Projects, renders and linearises one view of the batch. image_gradient: gradient of the loss.
  void Build(const TargetView<B>& target, Unit& unit, VectorView image_gradient) const;
  // The first and the last step of Build.
  void Project(const TargetView<B>& target, Unit& unit) const;
  void LinearizeLoss(Unit& unit, VectorView image_gradient) const;
  // Calls body(unit) for each view of the batch in turn. The views are cached, or each is built again for the call.
  template <class Body>
  void ForEachUnit(const Body& body) const;
  // Hv += J^T W d_image for one view. weighted: work space.
  void AddJTW(const Unit& unit, VectorView d_image, VectorView weighted, VectorView Hv);
  // Adds the Gram matrices of all views to blocks and sh_diagonal.
  void AddGram(S* blocks, S* sh_diagonal);
  static constexpr Index kGrain = 16384;

  // v *= scale_.
  void Scale(VectorView v) const;

  SplatProblemOptions options_;
  splat::Model<S> model_;
  std::vector<const TargetView<B>*> views_;
  double scale_;
  std::shared_ptr<SplatScratch<B>> scratch_;
  Index num_residuals_ = 0;
  std::shared_ptr<Loss> loss_;
  std::shared_ptr<Workspace> workspace_;
  Vector gradient_, rhs_;  // freed once requested; rhs_: with shrinkage only (for a part: the squares)
  SplatGrams<B> grams_;    // computed for the diagonal, kept for the preconditioner
  mutable Vector residuals_;
};

}  // namespace vesta::gs
