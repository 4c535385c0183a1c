#include "problems/gaussian_splatting/cameras/joint_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/cameras/joint_linearization.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/model/masked_loss.h"

namespace vesta::gs {

std::vector<BlockGroup> BlockGroupsOf(const JointProblemOptions& options, const JointLayout& layout) {
  std::vector<BlockGroup> groups = SplatBlockGroups(options.splats, options.splats.sh_blocks);
  const int n = layout.free.num_tangent();
  groups.push_back(
      {.size = n, .count = layout.views, .offset = layout.splats, .component_stride = 1, .block_stride = n});
  return groups;
}

template <class S>
JointProblem<S>::JointProblem(const JointProblemOptions& options, std::span<const TargetView<B>> views)
    : options_(options),
      views_(views),
      layout_{options.splats.Size(), static_cast<Index>(views.size()), options.free},
      splats_(std::make_shared<SplatProblem<B>>(options.splats, views)),
      scratch_(std::make_shared<JointScratch<S>>(options.splats.weights)) {
  VESTA_CHECK(!views.empty(), "no views to find cameras of");
  VESTA_CHECK(options.free.num_tangent() > 0, "views with neither pose nor colour to find");
  VESTA_CHECK(!options.free.lens, "lenses are no unknowns of the joint problem: views share them");
  VESTA_CHECK(options.prior.weight >= 0 && std::isfinite(options.prior.weight),
              "a prior of weight {}; choose 0 or more", options.prior.weight);
  VESTA_CHECK(options.prior.depth > 0 && std::isfinite(options.prior.depth), "a depth of {}; it must be above 0",
              options.prior.depth);
}

template <class S>
JointProblem<S>::JointProblem(const JointProblem& whole, const Share& views)
    : options_(whole.options_),
      views_(whole.views_.subspan(static_cast<std::size_t>(views.begin), static_cast<std::size_t>(views.size()))),
      layout_(whole.layout_),
      splats_(whole.splats_),
      scratch_(whole.scratch_) {
  options_.splats.is_part = true;
  layout_.views = views.size();
  layout_.views_before = views.begin, layout_.views_after = whole.layout_.views - views.end;
}

template <class S>
std::unique_ptr<JointProblem<S>> JointProblem<S>::MakePart(const Share& views) const {
  return std::unique_ptr<JointProblem>(new JointProblem(*this, views));
}

template <class S>
double JointProblem<S>::Cost(ConstView x) {
  std::vector<Index> all(views_.size());
  std::iota(all.begin(), all.end(), Index{0});
  return Cost(x, all);
}

template <class S>
double JointProblem<S>::Cost(ConstView x, std::span<const Index> units) {
  this->CheckSize(x);
  this->CheckUnits(units);
  const splat::Model<S> model{x.data(), options_.splats, options_.splats.sh_degree};
  splat::SplatView<S> view;
  HostBuffer<S> image;
  double cost = 0;
  for (const Index v : units) {
    const TargetView<B>& target = views_[static_cast<std::size_t>(v)];
    const ViewUnknowns unknowns = layout_.UnknownsOf(x, v);
    if (!std::ranges::all_of(unknowns.color.gain, [](double gain) { return gain > 0; })) {
      return std::numeric_limits<double>::infinity();
    }
    view.Build(model, Moved(target.camera, unknowns.motion), options_.splats.background.data(), scratch_->workspace);
    image.ResizeForOverwrite(target.truth.size());
    view.Render(image.data());
    unknowns.color.Apply(image.view());
    cost += EvaluateLoss(scratch_->loss, target, image.view()).cost;
    for (const double r : options_.prior.Residuals(unknowns, options_.free, image.size())) cost += r * r / 2;
  }
  return cost;
}

template <class S>
std::unique_ptr<Linearization<CpuBackend<S>>> JointProblem<S>::Linearize(ConstView x, int batch) {
  this->CheckSize(x);
  this->CheckBatch(batch);
  return std::make_unique<JointLinearization<S>>(options_, layout_, x, views_, scratch_);
}

template <class S>
bool JointProblem<S>::DampingMetric(ConstView x, ConstView diag_h, View D) {
  const Index n = layout_.splats;
  if (!splats_->DampingMetric(x.subspan(0, n), diag_h.subspan(0, n), D.subspan(0, n))) return false;
  std::copy(diag_h.begin() + n, diag_h.end(), D.begin() + n);
  return true;
}

template <class S>
void JointProblem<S>::Plus(B& backend, ConstView x, ConstView delta, View out) {
  const Index n = layout_.splats;
  backend.Copy(x, out);
  backend.Axpby(1.0, delta.subspan(0, n), 1.0, out.subspan(0, n));
  for (Index v = 0; v < layout_.views; ++v) {
    const auto own = layout_.StepOf(delta, v);
    const std::vector<double> step(own.begin(), own.end());
    layout_.SetUnknowns(gs::Plus(layout_.UnknownsOf(x, v), options_.free, {step.data(), own.size()}), v, out);
  }
}

template class JointProblem<float>;
template class JointProblem<double>;

}  // namespace vesta::gs
