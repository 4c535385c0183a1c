// SPDX-License-Identifier: Apache-2.0
// Splats, cameras and exposures as one least-squares problem of the engine: bundle adjustment by photographs, with
// Gaussians for points.
//
// To its view a camera's motion is a rigid motion of all Gaussians
// (kernels/gaussian_splatting/projection/camera_block.h), so that J v is still one tangent pass for each view and J^T u
// one adjoint pass. What no photograph tells is held by a weak prior (gauge.h).
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
  // Of the splats. All views make one batch and are held: batches and jacobian do not count.
  SplatProblemOptions splats;
  FreeUnknowns free = {};
  ViewPrior prior = {};
  // Whether views' unknowns can be eliminated (WithReducedSystem). Takes the memory of 6 to 8 more
  // images a view.
  bool eliminate_views = false;
};

std::vector<BlockGroup> BlockGroupsOf(const JointProblemOptions& options, const JointLayout& layout);

// The workspace of a joint problem and its linearizations, for one call at a time.
template <class B>
class JointScratch {
 public:
  using Vector = typename B::Vector;
  using VectorView = typename B::VectorView;

  explicit JointScratch(const PhotometricWeights& weights) : loss(weights) {}

  typename SplatBackend<B>::Loss loss;
  typename SplatBackend<B>::Workspace workspace;
  // Images of so many values, each until it is asked for again.
  VectorView Image(Index values) { return Of(values, image_); }
  VectorView Weighted(Index values) { return Of(values, weighted_); }

 private:
  static VectorView Of(Index values, Vector& images) {
    if (images.size() < values) images.ResizeForOverwrite(values);
    return images.view().subspan(0, values);
  }

  Vector image_, weighted_;
};

// For any memory space. x: JointLayout; units are views. The motion of a view is from its target.camera, which is in
// double, so that what x has to hold is small. Costs are infinite where a gain is not above 0. The same bits for any
// number of threads.
template <Backend B>
class JointProblem final : public Problem<B>, public OnManifold<B>, public InUnits<B>, public WithDampingMetric<B> {
 public:
  using S = typename B::Scalar;
  using typename Problem<B>::ConstVectorView;
  using typename Problem<B>::VectorView;

  // views must outlive the problem. Throws Error where there are none, where neither pose nor colour of them is free,
  // where lenses are, and for a prior out of range; for a truth that is not of its view's size where it is looked at.
  JointProblem(const JointProblemOptions& options, std::span<const TargetView<B>> views);

  const JointLayout& layout() const { return layout_; }
  Index num_parameters() const override { return layout_.num_parameters(); }
  Index num_tangent() const override { return layout_.num_tangent(); }
  Index num_units() const override { return layout_.views; }
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;
  // That of the splats' (SplatMetricOptions); of views diag(H).
  bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) override;
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;

  // Those of the splats, then one block for each view.
  std::vector<BlockGroup> block_groups() const { return BlockGroupsOf(options_, layout_); }

  // What the passes work in, free for others between calls.
  typename SplatBackend<B>::Workspace& workspace() { return scratch_->workspace; }

 private:
  JointProblemOptions options_;
  std::span<const TargetView<B>> views_;
  JointLayout layout_;
  SplatProblem<B> splats_;  // for its metric
  std::shared_ptr<JointScratch<B>> scratch_;
};

}  // namespace vesta::gs
