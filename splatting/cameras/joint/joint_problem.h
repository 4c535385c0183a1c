// SPDX-License-Identifier: Apache-2.0
// Splats, cameras and exposures as one least-squares problem: photometric bundle adjustment with Gaussians instead of
// points.
//
// In its own image, a camera motion acts like a rigid motion of all Gaussians
// (kernels/gaussian_splatting/projection/camera_block.h). So J v is still one tangent pass per view, and J^T u one
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
  // Options of the splats. All views form one batch and are cached; `batches` and `jacobian` are ignored.
  SplatProblemOptions splats;
  FreeUnknowns free = {};
  ViewPrior prior = {};
  // True if the unknowns of the views can be eliminated (WithReducedSystem). This takes the memory of 6 to 8 more
  // images per view.
  bool eliminate_views = false;
};

std::vector<BlockGroup> BlockGroupsOf(const JointProblemOptions& options, const JointLayout& layout);

// The workspace shared by a joint problem and its linearizations; one call at a time may use it.
template <class B>
class JointScratch {
 public:
  using Vector = typename B::Vector;
  using VectorView = typename B::VectorView;

  explicit JointScratch(const PhotometricWeights& weights) : loss(weights) {}

  typename SplatBackend<B>::Loss loss;
  typename SplatBackend<B>::Workspace workspace;
  // Image buffers of `values` numbers. Each call reuses the same buffer.
  VectorView Image(Index values) { return Of(values, image_); }
  VectorView Weighted(Index values) { return Of(values, weighted_); }

 private:
  static VectorView Of(Index values, Vector& images) {
    if (images.size() < values) images.ResizeForOverwrite(values);
    return images.view().subspan(0, values);
  }

  Vector image_, weighted_;
};

// The joint problem for any memory space. x: see JointLayout; the units are views. Motions are relative to
// target.camera, which is in double, so x holds only small numbers. Costs are infinite if a gain is not positive.
// Results are bit-identical for any number of threads.
template <Backend B>
class JointProblem final : public Problem<B>, public OnManifold<B>, public InUnits<B>, public WithDampingMetric<B> {
 public:
  using S = typename B::Scalar;
  using typename Problem<B>::ConstVectorView;
  using typename Problem<B>::VectorView;

  // views must outlive the problem. Throws Error without views, if neither pose nor colour is free, if lenses are free,
  // or if the prior is out of range. A truth of the wrong size throws at its first use.
  JointProblem(const JointProblemOptions& options, std::span<const TargetView<B>> views);

  const JointLayout& layout() const { return layout_; }
  Index num_parameters() const override { return layout_.num_parameters(); }
  Index num_tangent() const override { return layout_.num_tangent(); }
  Index num_units() const override { return layout_.views; }
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;
  // The splats' metric (SplatMetricOptions), and diag(H) for views.
  bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) override;
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;

  // The blocks of the splats, then one block per view.
  std::vector<BlockGroup> block_groups() const { return BlockGroupsOf(options_, layout_); }

  // The workspace of the passes; callers may use it between calls.
  typename SplatBackend<B>::Workspace& workspace() { return scratch_->workspace; }

 private:
  JointProblemOptions options_;
  std::span<const TargetView<B>> views_;
  JointLayout layout_;
  SplatProblem<B> splats_;  // provides the metric
  std::shared_ptr<JointScratch<B>> scratch_;
};

}  // namespace vesta::gs
