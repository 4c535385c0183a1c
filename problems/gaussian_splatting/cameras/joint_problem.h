// Splats, cameras, lenses and exposures as one least-squares problem of the engine: bundle adjustment by photographs,
// with Gaussians for points.
//
// To its view a camera's motion is a rigid motion of all Gaussians (kernels/gaussian_splatting/camera_block.h), so that
// J v is still one tangent pass for each view and J^T u one adjoint pass. So is what a lens does, which all its views
// share. What no photograph tells is held by a weak prior (view_prior.h).
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/cameras/joint_layout.h"
#include "problems/gaussian_splatting/cameras/joint_scratch.h"
#include "problems/gaussian_splatting/cameras/unbend.h"
#include "problems/gaussian_splatting/cameras/view_prior.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"

namespace vesta::gs {

struct JointProblemOptions {
  // Of the splats. All views make one batch and are held: batches and jacobian do not count.
  SplatProblemOptions splats;
  FreeUnknowns free = {};
  ViewPrior prior = {};
  // Whether views' unknowns can be eliminated (Linearization::MakeReducedSystem). Takes the memory of 6 to 8 more
  // images a view.
  bool eliminate_views = false;
  // Where lenses are free: which of them each view has; and where their radial distortion is, what its truth has been
  // unbent by already, unless the view is no photograph of a lens that bends. What x has of distortion that is not free
  // is passed over.
  std::vector<std::size_t> lens_of = {};
  std::vector<std::optional<RadialCoefficients>> unbent_by = {};
};

std::vector<BlockGroup> BlockGroupsOf(const JointProblemOptions& options, const JointLayout& layout);

// For any memory space. x: JointLayout; units are views. The motion of a view is from its target.camera, which is in
// double, so that what x has to hold is small. Costs are infinite where a gain is not above 0, or a lens is none
// (LensChange::is_sound, is_bend_sound). The same bits for any number of threads.
template <Backend B>
class JointProblem final : public Problem<B> {
 public:
  using S = typename B::Scalar;
  using typename Problem<B>::ConstView;
  using typename Problem<B>::View;

  // views must outlive the problem. Throws Error where there are none, where neither pose nor colour of them is free,
  // for lenses that are not one for each view, and for a prior out of range; for a truth that is not of its view's size
  // where it is looked at: those of views of other processes may be empty.
  JointProblem(const JointProblemOptions& options, std::span<const TargetView<B>> views);

  const JointLayout& layout() const { return layout_; }
  Index num_parameters() const override { return layout_.num_parameters(); }
  Index num_tangent() const override { return layout_.num_tangent(); }
  Index num_units() const override { return layout_.views; }
  double Cost(ConstView x) override;
  double Cost(ConstView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstView x, int batch) override;
  // That of the splats' (SplatMetricOptions); of lenses and views diag(H).
  bool DampingMetric(ConstView x, ConstView diag_h, View D) override;
  void Plus(B& backend, ConstView x, ConstView delta, View out) override;

  // Those of the splats, then one block for each lens and one for each view.
  std::vector<BlockGroup> block_groups() const { return BlockGroupsOf(options_, layout_); }
  bool eliminates_views() const { return options_.eliminate_views; }
  // The same problem on some of its views: at the x of the whole, with steps of the splats and of these views. It works
  // in the same memory: one call at a time of all of them.
  std::unique_ptr<JointProblem> MakePart(const Share& views) const;

  // What the passes work in, free for others between calls.
  typename SplatBackend<B>::Workspace& workspace() { return scratch_->workspace; }

 private:
  JointProblem(const JointProblem& whole, const Share& views);

  JointProblemOptions options_;
  std::span<const TargetView<B>> views_;
  JointLayout layout_;
  std::shared_ptr<SplatProblem<B>> splats_;  // for its metric
  std::shared_ptr<JointScratch<B>> scratch_;
};

}  // namespace vesta::gs
