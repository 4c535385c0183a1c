// SPDX-License-Identifier: Apache-2.0
// 3D Gaussian splatting as a least-squares problem. x holds the parameters of the Gaussians
// (kernels/gaussian_splatting/formulas/layout.h). A unit is a training view. The cost is the photometric loss summed
// over views, pixels and channels.
//
// J = J_raster J_project; s and W come from the loss (kernels/image/photometric_loss.h). By default the Jacobian is not
// stored; products recompute its entries from x. Only the sorted splats, the image and the loss fields of each view are
// stored.
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

// The views in the form that the linearizations use, and work space.
template <class B>
struct SplatScratch {
  using Vector = typename B::Vector;
  // One view, projected and rendered at x.
  struct Unit {
    const TargetView<B>* target;
    ImageShape shape;
    typename SplatBackend<B>::SplatView view;
    Vector image;
    typename SplatBackend<B>::Loss::Linearization loss;
  };
  std::vector<Unit> units;  // all views; with JacobianKind::kOnTheFly a single one, reused for each view
  Vector image_work, weighted_work;

  // Allocates `views` units and work space for images of up to `values` values.
  void Fit(std::size_t views, Index values) {
    if (units.size() < views) units.resize(views);
    for (Vector* work : {&image_work, &weighted_work}) {
      if (work->size() < values) work->ResizeForOverwrite(values);
    }
  }
};

// Options for a model with the layout of the base class.
struct SplatProblemOptions : SplatMetricOptions, splat::ModelLayout {
  std::array<double, 3> background{0, 0, 0};
  PhotometricWeights weights;
  // For merged batches choose views that are not neighbours: neighbouring views bias the merge.
  ViewBatchOptions batches;
  JacobianKind jacobian = JacobianKind::kCachedViews;
  LearningRates lr;
  // Unit of length of each Gaussian (model/length_units.h); null: all 1.
  std::shared_ptr<const std::vector<float>> units;
  // True for one part of a problem distributed over ranks. Its linearization returns squared gradients; RightHandSideOf
  // then needs the sums over all parts.
  bool is_part = false;
};

// Works in any memory space: SplatBackend<B> provides everything that depends on it.
template <Backend B>
class SplatProblem : public Problem<B>, public InUnits<B>, public InBatches<B>, public WithDampingMetric<B> {
 public:
  using Base = Problem<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;

  // views must outlive the problem. Throws Error if a truth image does not match the size of its view, or if the number
  // of units of length is neither 0 nor the number of Gaussians. The truth may be missing for views that only the parts
  // of other ranks use.
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
  // The same problem on a subset of the views. It shares work memory with this one: only one call at a time.
  std::unique_ptr<SplatProblem> MakePart(std::span<const TargetView<B>> views) const;

  // Work space of the passes; others may use it between calls.
  typename SplatBackend<B>::Workspace& workspace() { return *workspace_; }

 private:
  SplatProblem(const SplatProblem& whole, std::span<const TargetView<B>> views);
  // The view, after checking that its truth is there.
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
