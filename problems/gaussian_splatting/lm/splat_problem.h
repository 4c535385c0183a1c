// SPDX-License-Identifier: Apache-2.0
// 3D Gaussian splatting as a least-squares problem (solver/problem.h). x contains the parameters of the Gaussians
// (kernels/gaussian_splatting/formulas/layout.h). The residuals are the colour errors of the training views; a unit
// (solver/problem_interfaces.h) is a view. The cost is the photometric loss summed over views, pixels and channels.
//
// The Jacobian is J = J_raster J_project: J_project leads from parameters to projected splats, J_raster from these to
// pixels. kernels/image/photometric_loss.h computes the loss's first derivative s by the pixels, and its curvature W.
// JacobianKind selects the data stored for products with J.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/image/loss_options.h"
#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/model/learning_rates.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/problem_interfaces.h"

namespace vesta::gs {

// Rendered views of a linearization, and work memory.
template <class B>
struct SplatScratch {
  using Vector = typename B::Vector;
  // A view, projected and rendered at x.
  struct Unit {
    const TargetView<B>* target;
    ImageShape shape;
    typename SplatBackend<B>::SplatView view;
    Vector image;
    typename SplatBackend<B>::Loss::Linearization loss;
  };
  std::vector<Unit> units;  // one per view; with JacobianKind::kOnTheFly one for all
  Vector image_work, weighted_work;

  // Grows to at least `views` units and images of `values` numbers.
  void Fit(std::size_t views, Index values) {
    if (units.size() < views) units.resize(views);
    for (Vector* work : {&image_work, &weighted_work}) {
      if (work->size() < values) work->ResizeForOverwrite(values);
    }
  }
};

struct SplatProblemOptions : SplatMetricOptions, splat::ModelLayout {
  std::array<double, 3> background{0, 0, 0};
  PhotometricWeights weights;
  // Merged batches should each have views from all sides (BatchChoice::kStrided or kRandom): a step from neighbouring
  // views alone fits only these views.
  ViewBatchOptions batches;
  JacobianKind jacobian = JacobianKind::kCachedViews;
  LearningRates lr;
  // Unit of length of each Gaussian (model/length_units.h); null: all 1.
  std::shared_ptr<const std::vector<float>> units;
  // True for one part of a problem on several ranks. Gradient shrinkage needs sums over all parts: each part returns
  // SquaredGradients, and RightHandSideOf combines them.
  bool is_part = false;
};

// SplatBackend<B> provides the types that depend on the backend B.
template <Backend B>
class SplatProblem : public Problem<B>, public InUnits<B>, public InBatches<B>, public WithDampingMetric<B> {
 public:
  using Base = Problem<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;

  // views must outlive the problem. Throws Error if a photograph does not have its view's size, or if options.units
  // does not have one value per Gaussian. Photographs (TargetView::truth) may be missing for views that only other
  // ranks use; using such a view throws Error.
  SplatProblem(const SplatProblemOptions& options, std::span<const TargetView<B>> views);

  Index num_parameters() const override;
  int num_batches() const override { return batches_.num_batches(); }
  Index num_units() const override { return static_cast<Index>(views_.size()); }
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override { return this->LinearizeOnlyBatch(x); }
  std::unique_ptr<Linearization<B>> LinearizeBatch(ConstVectorView x, int batch) override;
  bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) override;
  void OnNewPoint(int turn) override { batches_.OnNewPoint(turn); }

  const SplatProblemOptions& options() const { return options_; }
  std::span<const TargetView<B>> views() const { return views_; }
  // The same problem on some views, with is_part set and one batch. It shares work memory with this problem, so only
  // one of the two may be called at a time. `views` must outlive the result.
  std::unique_ptr<SplatProblem> MakePart(std::span<const TargetView<B>> views) const;

  // Work memory of the renderer, free for the caller between calls.
  typename SplatBackend<B>::Workspace& workspace() { return *workspace_; }

 private:
  SplatProblem(const SplatProblem& whole, std::span<const TargetView<B>> views);
  // Throws Error if the photograph is missing.
  const TargetView<B>& ViewAt(Index unit) const;

  SplatProblemOptions options_;
  std::span<const TargetView<B>> views_;
  ViewBatches batches_;
  std::shared_ptr<typename SplatBackend<B>::Loss> loss_;
  std::shared_ptr<typename SplatBackend<B>::Workspace> workspace_;
  std::shared_ptr<SplatScratch<B>> scratch_;  // shared by parts
  Buffer<float, typename B::Space> units_;    // units of length; empty: all 1
};

}  // namespace vesta::gs
