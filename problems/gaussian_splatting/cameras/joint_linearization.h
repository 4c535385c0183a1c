// Splats, cameras, lenses and exposures at one x.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "problems/gaussian_splatting/cameras/joint_problem.h"
#include "problems/gaussian_splatting/cameras/view_columns.h"
#include "problems/gaussian_splatting/lm/splat_grams.h"

namespace vesta::gs {

// One view, as joint_view.h shows it.
template <class S>
struct JointUnit {
  const TargetView<CpuBackend<S>>* target = nullptr;
  ViewUnknowns unknowns;
  std::optional<RadialCoefficients> unbent_by;  // BendOf
  splat::SplatView<S> view;
  HostBuffer<S> rendered;  // before the exposure
  typename PhotometricLoss<S>::Linearization W;
  std::vector<double> prior, prior_jacobian;  // ViewPrior's
  // J_c^T W J_c of the view's own unknowns and then of its lens, the prior's included; made when it is asked for. W J_c
  // of its own: only where views may be eliminated.
  std::vector<double> curvature;
  ViewColumns<CpuBackend<S>> weighted;

  Index values() const { return rendered.size(); }
};

template <class S>
class JointLinearization final : public Linearization<CpuBackend<S>> {
 public:
  using B = CpuBackend<S>;
  using typename Linearization<B>::ConstView;
  using typename Linearization<B>::View;

  // scratch is shared with the problem.
  JointLinearization(const JointProblemOptions& options, const JointLayout& layout, ConstView x,
                     std::span<const TargetView<B>> views, std::shared_ptr<JointScratch<S>> scratch);

  // Residuals are the colour differences e = shown - truth, view after view, each 3 planes; then for each view those of
  // the prior.
  Index num_residuals() const override { return num_values_ + num_priors(); }
  Index num_parameters() const override { return layout_.num_tangent(); }
  ConstView residuals() const override;
  void ApplyJ(ConstView v, View u) override;
  void ApplyJT(ConstView u, View g) override;
  // The identity on the prior's.
  void ApplyW(ConstView u, View Wu) override;
  bool weighted() const override { return true; }
  void ApplyH(ConstView v, View Hv) override;
  void Gradient(View g) override;
  // The gradient; that of the splats shrunk where the views disagree (lm/view_agreement.h).
  bool has_own_descent() const override { return options_.splats.view_agreement > 0; }
  void Descent(View d) override;
  void SquaredGradients(View squares) override;
  // gradient, squares: of the whole.
  void DescentOf(Index units, ConstView gradient, View squares) const override;
  // Exact for lenses and views; for splats exact for W's pointwise part, which stands in for W (docs/mathematics.md).
  void DiagJTJ(View d) override;
  std::vector<BlockGroup> block_groups() const override { return BlockGroupsOf(options_, layout_); }
  void BlockGram(BlockDiagonal<B>& blocks) override;
  // Null unless the options have it.
  std::unique_ptr<ReducedSystem<B>> MakeReducedSystem() override;

  // The parts that the reduced system is made of.
  const JointLayout& layout() const { return layout_; }
  const std::vector<JointUnit<S>>& units() const { return units_; }
  // d_image = J of view v by what is no view's own, splats and lens; g += its transpose times u, an image, which is
  // overwritten.
  void ApplySharedJ(Index v, ConstView step, View d_image);
  void AddSharedJT(Index v, View u, View g);
  // y += what view v's prior adds to H x of its lens.
  void AddPriorOfLens(Index v, ConstView x, View y) const;
  // values of the lenses' block group = the sums over each one's views of what is given of a view.
  void AddLensBlocks(const std::function<std::vector<double>(Index)>& of_view, View values) const;
  void ApplyW(const JointUnit<S>& unit, ConstView u, View Wu) { scratch_->loss.ApplyW(unit.W, u, Wu); }
  // What both hold of the diagonal and the blocks.
  const SplatGrams<B>& Grams();
  const std::vector<double>& CurvatureOf(std::size_t view) { return MakeCurvature(units_[view]); }
  // Of what a part has of the splats only sums over the parts are held.
  bool is_part() const { return options_.splats.is_part; }
  void ReleaseGrams() { grams_.Release(); }
  JointScratch<S>& scratch() { return *scratch_; }

 private:
  Index num_priors() const { return layout_.views * layout_.free.num_tangent(); }
  // Builds all views, and sums their gradients, of which comes the descent; of a part their squares. A part is built
  // when it is first asked for something, so that gradients are held of one at a time.
  void MakeUnits();
  void EnsureUnits() {
    if (units_.empty()) MakeUnits();
  }
  // squares becomes the descent of the splats.
  void DescentOfSplats(Index units, ConstView gradient, View squares) const;
  void Build(Index v, JointUnit<S>& unit, View image_gradient);
  // d_image = J v of view v, without the prior's; g += J^T u, u overwritten.
  void ApplyViewJ(Index v, ConstView step, View d_image);
  void AddViewJT(Index v, View u, View g);
  // out = J_p v and g += J_p^T u of the prior of view v.
  void ApplyPriorJ(Index v, ConstView step, S* out) const;
  void AddPriorJT(Index v, const S* u, View g) const;
  const std::vector<double>& MakeCurvature(JointUnit<S>& unit);
  // d_image = the derivative of what is rendered.
  void ApplyImageJ(Index v, ConstView step, const splat::PoseTangent* pose, View d_image);
  // d_image += what the lens's bend adds to the derivative of what is shown.
  void AddBendJ(Index v, ConstView step, View d_image);

  JointProblemOptions options_;
  JointLayout layout_;
  ConstView x_;
  splat::Model<S> model_;
  std::span<const TargetView<B>> views_;
  std::vector<JointUnit<S>> units_;
  Index num_values_ = 0;
  std::shared_ptr<JointScratch<S>> scratch_;
  HostBuffer<S> gradient_, descent_;  // the second: the splats', where it is its own
  SplatGrams<B> grams_;
  mutable HostBuffer<S> residuals_;
};

}  // namespace vesta::gs
