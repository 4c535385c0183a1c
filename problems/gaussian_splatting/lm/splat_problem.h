// SPDX-License-Identifier: Apache-2.0
// 3D Gaussian splatting as a least-squares problem of the engine: x are the Gaussians' parameters
// (kernels/gaussian_splatting/formulas/layout.h), a unit is a training view, the cost the photometric loss summed over
// views, pixels and channels.
//
// J = J_raster J_project, s and W from the loss (kernels/image/photometric_loss.h). Unless options say otherwise
// products recompute what they need from x: no Jacobian is stored, only each view's sorted splats, image and loss
// fields.
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

// The views of the splatting problem as its linearizations go through them, and memory to work in.
template <class B>
struct SplatScratch {
  using Vector = typename B::Vector;
  // A view at x.
  struct Unit {
    const TargetView<B>* target;
    ImageShape shape;
    typename SplatBackend<B>::SplatView view;
    Vector image;
    typename SplatBackend<B>::Loss::Linearization loss;
  };
  std::vector<Unit> units;  // all views; of JacobianKind::kOnTheFly one, for each in turn
  Vector image_work, weighted_work;

  // Room for so many views, whose images have so many values at most.
  void Fit(std::size_t views, Index values) {
    if (units.size() < views) units.resize(views);
    for (Vector* work : {&image_work, &weighted_work}) {
      if (work->size() < values) work->ResizeForOverwrite(values);
    }
  }
};

// Of a model so laid out.
struct SplatProblemOptions : SplatMetricOptions, splat::ModelLayout {
  std::array<double, 3> background{0, 0, 0};
  PhotometricWeights weights;
  // Merged batches want views that are not neighbours: the merge is biased by those.
  ViewBatchOptions batches;
  JacobianKind jacobian = JacobianKind::kCachedViews;
  LearningRates lr;
  // Of length, for each Gaussian (model/length_units.h); null: all 1.
  std::shared_ptr<const std::vector<float>> units;
  // Of a problem that is spread over processes: its linearization leaves the descent to who knows all parts.
  bool is_part = false;
};

// For any memory space: SplatBackend<B> says what of it differs.
template <Backend B>
class SplatProblem : public Problem<B>, public InUnits<B>, public InBatches<B>, public WithDampingMetric<B> {
 public:
  using Base = Problem<B>;
  using typename Base::ConstVectorView;
  using typename Base::VectorView;

  // views must outlive the problem. Throws Error for a truth that is not of its view's size, and unless there is a unit
  // of length for each Gaussian or none. The truth may be missing of views that only others' parts ask for.
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
  // The same problem on some of its views, which works in the same memory: one call at a time of all of them.
  std::unique_ptr<SplatProblem> MakePart(std::span<const TargetView<B>> views) const;

  // What the passes work in, free for others between calls.
  typename SplatBackend<B>::Workspace& workspace() { return *workspace_; }

 private:
  SplatProblem(const SplatProblem& whole, std::span<const TargetView<B>> views);
  // To be looked at.
  const TargetView<B>& ViewAt(Index unit) const;

  SplatProblemOptions options_;
  std::span<const TargetView<B>> views_;
  ViewBatches batches_;
  std::shared_ptr<typename SplatBackend<B>::Loss> loss_;
  std::shared_ptr<typename SplatBackend<B>::Workspace> workspace_;
  std::shared_ptr<SplatScratch<B>> scratch_;  // of parts
  Buffer<float, typename B::Space> units_;    // of length; empty: all 1
};

}  // namespace vesta::gs
