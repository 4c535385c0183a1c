// SPDX-License-Identifier: Apache-2.0
// Definitions of joint_problem.h. Include like joint_linearization.inl.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "splatting/cameras/joint/joint_layout.h"
#include "splatting/cameras/joint/joint_linearization.h"
#include "splatting/cameras/joint/joint_problem.h"
#include "splatting/cameras/unknowns/exposed_colors.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::gs {

template <Backend B>
JointProblem<B>::JointProblem(const JointProblemOptions& options, std::span<const TargetView<B>> views)
    : options_(options),
      views_(views),
      layout_{options.splats.Size(), static_cast<Index>(views.size()), options.free},
      splats_(options.splats, views),
      scratch_(std::make_shared<JointScratch<B>>(options.splats.weights)) {
  VESTA_CHECK(!views.empty(), "a joint problem without views");
  VESTA_CHECK(options.free.pose || options.free.color, "neither pose nor colour is free");
  VESTA_CHECK(!options.free.lens, "free lenses: only the Adam stage optimises them");
  VESTA_CHECK(options.prior.weight >= 0 && std::isfinite(options.prior.weight),
              "a prior of weight {}; choose 0 or more", options.prior.weight);
  VESTA_CHECK(options.prior.depth > 0 && std::isfinite(options.prior.depth), "a depth of {}; it must be above 0",
              options.prior.depth);
}

template <Backend B>
double JointProblem<B>::Cost(ConstVectorView x) {
  std::vector<Index> all(views_.size());
  std::iota(all.begin(), all.end(), Index{0});
  return Cost(x, all);
}

template <Backend B>
double JointProblem<B>::Cost(ConstVectorView x, std::span<const Index> units) {
  this->CheckSize(x);
  this->CheckUnits(units);
  const splat::Model<S> model{x.data(), options_.splats, options_.splats.sh_degree};
  typename SplatBackend<B>::SplatView view;
  typename B::Vector image;
  const ConstHostTail<B> rest(x, layout_.splats);
  double cost = 0;
  for (const Index v : units) {
    const TargetView<B>& target = views_[static_cast<std::size_t>(v)];
    CheckTruth(target);
    const ViewUnknowns unknowns = layout_.UnknownsOf(rest.view(), v);
    const bool has_gains = std::ranges::all_of(unknowns.color.gain, [](double gain) { return gain > 0; });
    if (!has_gains) return std::numeric_limits<double>::infinity();
    view.Build(model, AsFound(target.camera, unknowns), options_.splats.background.data(), scratch_->workspace);
    image.ResizeForOverwrite(target.truth.size());
    view.Render(image.data());
    Expose<B>(unknowns.color, image.view());
    cost += EvaluateLoss<B>(scratch_->loss, target, image.view()).cost;
    for (const double r : options_.prior.Residuals(unknowns, options_.free, image.size())) cost += r * r / 2;
  }
  return cost;
}

template <Backend B>
std::unique_ptr<Linearization<B>> JointProblem<B>::Linearize(ConstVectorView x) {
  this->CheckSize(x);
  return std::make_unique<JointLinearization<B>>(options_, layout_, x, views_, scratch_);
}

template <Backend B>
bool JointProblem<B>::DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) {
  const Index n = layout_.splats;
  if (!splats_.DampingMetric(x.subspan(0, n), diag_h.subspan(0, n), D.subspan(0, n))) return false;
  B().Copy(diag_h.subspan(n, diag_h.size() - n), D.subspan(n, D.size() - n));
  return true;
}

template <Backend B>
void JointProblem<B>::Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) {
  const Index n = layout_.splats;
  backend.Copy(x, out);
  backend.Axpby(1.0, delta.subspan(0, n), 1.0, out.subspan(0, n));
  const ConstHostTail<B> from(x, n), by(delta, n);
  HostTail<B> to(out, n);
  for (Index v = 0; v < layout_.views; ++v) {
    const HostSpan<const S> own = layout_.StepOf(by.view(), v);
    const std::vector<double> step(own.begin(), own.end());
    const HostSpan<const double> numbers(step.data(), static_cast<Index>(step.size()));
    layout_.SetUnknowns(gs::Plus(layout_.UnknownsOf(from.view(), v), options_.free, numbers), v, to.view());
  }
  to.Store();
}

}  // namespace vesta::gs
