// SPDX-License-Identifier: Apache-2.0
// Linearization of the splatting problem at one x, for one batch of views (lm/splat_problem.h). The Jacobian J has a
// row per pixel and channel and a column per parameter.
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

  // Gradient and curvature are `scale` times the sums over `views`. loss, workspace and scratch are work memory. The
  // problem and its linearizations share loss and workspace, so only one of them may be called at a time. scratch may
  // be shared only with JacobianKind::kOnTheFly, which stores nothing there between calls; null: allocated here.
  SplatLinearization(const SplatProblemOptions& options, ConstVectorView x, std::vector<const TargetView<B>*> views,
                     double scale, std::shared_ptr<Loss> loss, std::shared_ptr<Workspace> workspace,
                     std::shared_ptr<SplatScratch<B>> scratch = nullptr);

  // Colour differences e = rendered image - photograph: view after view, 3 planes (red, green, blue) each. Masked
  // pixels have residual 0.
  Index num_residuals() const override { return num_residuals_; }
  Index num_parameters() const override { return options_.Size(); }
  ConstVectorView residuals() const override;
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  void ApplyW(ConstVectorView u, VectorView Wu) override;
  // Computes H v = J^T W J v view by view, with J v of one view in memory.
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  void Gradient(VectorView g) override;
  // The negative gradient, shrunk (lm/gradient_shrinkage.h).
  bool has_own_right_hand_side() const override { return options_.gradient_shrinkage > 0; }
  void RightHandSide(VectorView d) override;
  // Sum over the views of their squared gradients, per entry. Only for options.is_part.
  void SquaredGradients(VectorView squares) override;
  // gradient and squares: sums over all parts, which have `units` views. Afterwards `squares` is the right-hand side.
  void RightHandSideOf(Index units, ConstVectorView gradient, VectorView squares) const override;
  // DiagJTJ and BlockGram use a simpler, diagonal matrix instead of W (docs/mathematics.md, section 4).
  void DiagJTJ(VectorView d) override;
  std::vector<BlockGroup> block_groups() const override;
  void BlockGram(BlockDiagonal<B>& blocks) override;
  bool blocks_give_diagonal() const override { return true; }

 private:
  using Vector = typename B::Vector;
  using Unit = typename SplatScratch<B>::Unit;
  // Renders and linearises all views and sums their gradients. Also computes the right-hand side with gradient
  // shrinkage (for a part: the squared gradients), and stores the Jacobian with kCache16 and kCache32.
  void BuildViews();
  // Projects, renders and linearises one view. image_gradient: gradient of the loss.
  void Build(const TargetView<B>& target, Unit& unit, VectorView image_gradient) const;
  // The first and the last step of Build.
  void Project(const TargetView<B>& target, Unit& unit) const;
  void LinearizeLoss(Unit& unit, VectorView image_gradient) const;
  // Calls body(unit) for each view of the batch. With kOnTheFly builds each view again first.
  template <class Body>
  void ForEachView(const Body& body) const;
  // Hv += scale_ J^T W d_image for one view. d_image: a product J v; overwritten, like `weighted`.
  void AddJTW(const Unit& unit, VectorView d_image, VectorView weighted, VectorView Hv);
  // Adds the diagonal blocks of H of all views (SplatGrams).
  void AddGram(S* blocks, S* sh_diagonal);
  static constexpr Index kGrain = 16384;

  void Scale(VectorView v) const;

  SplatProblemOptions options_;
  splat::Model<S> model_;
  std::vector<const TargetView<B>*> views_;
  double scale_;
  std::shared_ptr<SplatScratch<B>> scratch_;
  Index num_residuals_ = 0;
  std::shared_ptr<Loss> loss_;
  std::shared_ptr<Workspace> workspace_;
  Vector gradient_;      // of the cost; freed once requested
  Vector rhs_;           // right-hand side; of a part: the squared gradients; freed once requested
  SplatGrams<B> grams_;  // computed by DiagJTJ, freed by BlockGram
  mutable Vector residuals_;
};

}  // namespace vesta::gs
