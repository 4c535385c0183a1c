// SPDX-License-Identifier: Apache-2.0
// Gaussians ("splats"), cameras and exposures as one least-squares problem: photometric bundle adjustment with
// Gaussians instead of points.
//
// A camera motion changes the image like a rigid motion of all Gaussians
// (kernels/gaussian_splatting/projection/camera_block.h). So J v still takes one tangent pass per view, and J^T u one
// adjoint pass. A weak prior fixes the gauge (gauge.h).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "splatting/cameras/joint/joint_layout.h"
#include "splatting/cameras/unknowns/gauge.h"

namespace vesta::gs {

struct JointProblemOptions {
  // All views form one cached batch, so `batches` and `jacobian` are ignored.
  SplatProblemOptions splats;
  FreeUnknowns free = {};
  ViewPrior prior = {};
  // True: linearizations offer the reduced system without the views' unknowns (WithReducedSystem). Needs 6 to 8 more
  // images per view.
  bool eliminate_views = false;
};

std::vector<BlockGroup> BlockGroupsOf(const JointProblemOptions& options, const JointLayout& layout);

// Shared by a joint problem and its linearizations. Only one of their functions may run at a time.
template <class B>
class JointScratch {
 public:
  using Vector = typename B::Vector;
  using VectorView = typename B::VectorView;

  explicit JointScratch(const PhotometricWeights& weights) : loss(weights) {}

  typename SplatBackend<B>::Loss loss;
  typename SplatBackend<B>::Workspace workspace;
  // Two image buffers of at least `values` numbers. Each function returns the same buffer every time.
  VectorView Image(Index values) { return Of(values, image_); }
  VectorView Weighted(Index values) { return Of(values, weighted_); }

 private:
  static VectorView Of(Index values, Vector& images) {
    if (images.size() < values) images.ResizeForOverwrite(values);
    return images.view().subspan(0, values);
  }

  Vector image_, weighted_;
};

// x: see JointLayout. The units of InUnits are the views. Camera motions in x are relative to TargetView::camera
// (double), so x has only small numbers. The cost is infinite if a gain is not positive. Bit-identical for any number
// of threads.
template <Backend B>
class JointProblem final : public Problem<B>, public OnManifold<B>, public InUnits<B>, public WithDampingMetric<B> {
 public:
  using S = typename B::Scalar;
  using typename Problem<B>::ConstVectorView;
  using typename Problem<B>::VectorView;

  // views must outlive the problem. Throws Error without views, if neither pose nor colour is free, if lenses are free,
  // or if the prior is out of range. A photograph of the wrong size throws Error at its first use.
  JointProblem(const JointProblemOptions& options, std::span<const TargetView<B>> views);

  const JointLayout& layout() const { return layout_; }
  Index num_parameters() const override { return layout_.num_parameters(); }
  Index num_tangent() const override { return layout_.num_tangent(); }
  Index num_units() const override { return layout_.views; }
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;
  // SplatMetricOptions for Gaussians, diag(H) for the views' unknowns.
  bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) override;
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;

  // The blocks of the splats, then one block per view.
  std::vector<BlockGroup> block_groups() const { return BlockGroupsOf(options_, layout_); }

  // Work memory of the renderer, free for callers while no function of the problem runs.
  typename SplatBackend<B>::Workspace& workspace() { return scratch_->workspace; }

 private:
  JointProblemOptions options_;
  std::span<const TargetView<B>> views_;
  JointLayout layout_;
  SplatProblem<B> splats_;  // provides the metric
  std::shared_ptr<JointScratch<B>> scratch_;
};

}  // namespace vesta::gs
