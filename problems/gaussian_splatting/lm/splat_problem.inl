// SPDX-License-Identifier: Apache-2.0
// Implementation of lm/splat_problem.h.
#pragma once

#include <numeric>

#include "kernels/core/check.h"
#include "kernels/core/for_each.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/lm/length_metric.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/lm/splat_linearization.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/masked_loss.h"

namespace vesta::gs {

template <Backend B>
SplatProblem<B>::SplatProblem(const SplatProblemOptions& options, std::span<const TargetView<B>> views)
    : options_(options),
      views_(views),
      batches_(options.batches, static_cast<Index>(views.size())),
      loss_(std::make_shared<typename SplatBackend<B>::Loss>(options.weights)),
      workspace_(std::make_shared<typename SplatBackend<B>::Workspace>()),
      scratch_(std::make_shared<SplatScratch<B>>()) {
  if (options.units) {
    const HostSpan<const float> units(options.units->data(), static_cast<Index>(options.units->size()));
    VESTA_CHECK(units.size() == options.count, "{} units of length do not match {} Gaussians", units.size(),
                options.count);
    units_.CopyFrom(units);
    options_.units.reset();  // units_ is used from here on
  }
  for (const TargetView<B>& view : views) {
    if (!view.truth.empty()) CheckTruth(view);
  }
}

template <Backend B>
const TargetView<B>& SplatProblem<B>::ViewAt(Index unit) const {
  const TargetView<B>& view = views_[static_cast<std::size_t>(unit)];
  CheckTruth(view);
  return view;
}

// A part does not need the units of the damping metric.
template <Backend B>
SplatProblem<B>::SplatProblem(const SplatProblem& whole, std::span<const TargetView<B>> views)
    : options_(whole.options_),
      views_(views),
      batches_({}, static_cast<Index>(views.size())),
      loss_(whole.loss_),
      workspace_(whole.workspace_),
      scratch_(whole.scratch_) {
  options_.batches = {};
  options_.is_part = true;
}

template <Backend B>
std::unique_ptr<SplatProblem<B>> SplatProblem<B>::MakePart(std::span<const TargetView<B>> views) const {
  return std::unique_ptr<SplatProblem>(new SplatProblem(*this, views));
}

template <Backend B>
Index SplatProblem<B>::num_parameters() const {
  return options_.Size();
}

template <Backend B>
double SplatProblem<B>::Cost(ConstVectorView x) {
  std::vector<Index> all(views_.size());
  std::iota(all.begin(), all.end(), Index{0});
  return Cost(x, all);
}

template <Backend B>
double SplatProblem<B>::Cost(ConstVectorView x, std::span<const Index> units) {
  this->CheckSize(x);
  const splat::Model<typename B::Scalar> model{x.data(), options_, options_.sh_degree};
  typename SplatBackend<B>::SplatView view;
  typename B::Vector image;
  double cost = 0;
  for (const Index unit : units) {
    const TargetView<B>& target = ViewAt(unit);
    view.Build(model, target.camera, options_.background.data(), *workspace_);
    image.ResizeForOverwrite(target.truth.size());
    view.Render(image.data());
    cost += EvaluateLoss(*loss_, target, image.view()).cost;
  }
  return cost;
}

template <Backend B>
std::unique_ptr<Linearization<B>> SplatProblem<B>::LinearizeBatch(ConstVectorView x, int batch) {
  this->CheckSize(x);
  this->CheckBatch(batch);
  std::vector<const TargetView<B>*> views;
  for (const Index v : batches_.views(batch)) views.push_back(&ViewAt(v));
  const bool shares = options_.is_part && options_.jacobian == JacobianKind::kOnTheFly;
  return std::make_unique<SplatLinearization<B>>(options_, x, std::move(views), batches_.scale(), loss_, workspace_,
                                                 shares ? scratch_ : nullptr);
}

template <Backend B>
bool SplatProblem<B>::DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) {
  if (options_.damping != LmDamping::kLearningRates) return false;
  using S = typename B::Scalar;
  B backend;
  const Index n = options_.count;
  typename B::Vector ones(n);
  backend.Fill(1, ones);
  const double sum = backend.Dot(diag_h.subspan(splat::kOpacity * n, n), ones.view());
  const std::vector<double> metric = RatesMetric(options_, sum);
  for (int a = 0; a < static_cast<int>(metric.size()); ++a) {
    backend.Fill(metric[static_cast<std::size_t>(a)], D.subspan(options_.Offset(a), options_.Rows(a)));
  }
  if (metric.empty()) return false;
  ForEach<typename B::Space>(n, 4096, LengthMetric<S>{n, units_.empty() ? nullptr : units_.data(), x.data(), D.data()});
  return true;
}

}  // namespace vesta::gs
