// SPDX-License-Identifier: Apache-2.0
// Implementation of lm/splat_linearization.h.
#pragma once

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/for_each.h"
#include "problems/gaussian_splatting/lm/gradient_shrinkage.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/lm/splat_linearization.h"
#include "problems/gaussian_splatting/model/masked_loss.h"

namespace vesta::gs {

template <Backend B>
SplatLinearization<B>::SplatLinearization(const SplatProblemOptions& options, ConstVectorView x,
                                          std::vector<const TargetView<B>*> views, double scale,
                                          std::shared_ptr<Loss> loss, std::shared_ptr<Workspace> workspace,
                                          std::shared_ptr<SplatScratch<B>> scratch)
    : options_(options),
      views_(std::move(views)),
      scale_(scale),
      scratch_(scratch ? std::move(scratch) : std::make_shared<SplatScratch<B>>()),
      loss_(std::move(loss)),
      workspace_(std::move(workspace)) {
  model_ = {x.data(), options, options.sh_degree};
  Index largest = 0;
  for (const TargetView<B>* view : views_) {
    const Index values = view->shape().NumValues();
    num_residuals_ += values;
    largest = std::max(largest, values);
  }
  const bool rebuilds = options.jacobian == JacobianKind::kOnTheFly;
  scratch_->Fit(rebuilds ? std::min<std::size_t>(views_.size(), 1) : views_.size(), largest);
  // A part without cached views computes its gradient only on request.
  if (!options.is_part || !rebuilds) BuildViews();
}

template <Backend B>
void SplatLinearization<B>::BuildViews() {
  using Space = typename B::Space;
  gradient_.Resize(num_parameters());
  const bool steers = has_own_right_hand_side();
  Vector of_view;
  if (steers) of_view.Resize(num_parameters()), rhs_.Resize(num_parameters());
  for (std::size_t i = 0; i < views_.size(); ++i) {
    Unit& unit = scratch_->units[i % scratch_->units.size()];
    const VectorView image_gradient = scratch_->image_work.view().subspan(0, views_[i]->shape().NumValues());
    Build(*views_[i], unit, image_gradient);
    Scale(image_gradient);
    unit.view.AddJT(model_, unit.image.data(), image_gradient.data(), (steers ? of_view : gradient_).data(),
                    *workspace_);
    if (steers) {
      ForEach<Space>(num_parameters(), kGrain, AddViewGradient<S>{of_view.data(), gradient_.data(), rhs_.data()});
    }
    // The cache comes after the gradient, so that the gradient is exact.
    if (IsCached(options_.jacobian)) {
      unit.view.CacheJacobian(unit.image.data(), CacheFormatOf(options_.jacobian), *workspace_);
    }
  }
  if (steers && !options_.is_part) RightHandSideOf(static_cast<Index>(views_.size()), gradient_, rhs_);
}

template <Backend B>
void SplatLinearization<B>::Build(const TargetView<B>& target, Unit& unit, VectorView image_gradient) const {
  Project(target, unit);
  unit.view.Render(unit.image.data());
  LinearizeLoss(unit, image_gradient);
}

template <Backend B>
void SplatLinearization<B>::Project(const TargetView<B>& target, Unit& unit) const {
  unit.target = &target;
  unit.shape = target.shape();
  unit.view.Build(model_, target.camera, options_.background.data(), *workspace_);
  unit.image.ResizeForOverwrite(unit.shape.NumValues());
}

template <Backend B>
void SplatLinearization<B>::LinearizeLoss(Unit& unit, VectorView image_gradient) const {
  gs::LinearizeLoss(*loss_, *unit.target, unit.image.view(), image_gradient, unit.loss);
}

template <Backend B>
template <class Body>
void SplatLinearization<B>::ForEachView(const Body& body) const {
  if (options_.jacobian != JacobianKind::kOnTheFly) {
    for (Unit& unit : scratch_->units) body(unit);
    return;
  }
  for (const TargetView<B>* view : views_) {
    Unit& unit = scratch_->units.front();
    Build(*view, unit, scratch_->image_work.view().subspan(0, view->shape().NumValues()));
    body(unit);
  }
}

template <Backend B>
void SplatLinearization<B>::Scale(VectorView v) const {
  if (scale_ != 1) B().Axpby(scale_, v, 0.0, v);
}

template <Backend B>
auto SplatLinearization<B>::residuals() const -> ConstVectorView {
  if (residuals_.empty()) {
    residuals_.ResizeForOverwrite(num_residuals_);
    Index at = 0;
    ForEachView([&](const Unit& unit) {
      const VectorView part = residuals_.view().subspan(at, unit.image.size());
      B().Copy(unit.image, part);
      B().Axpby(-1.0, unit.target->truth, 1.0, part);
      at += unit.image.size();
    });
  }
  return residuals_.view();
}

template <Backend B>
void SplatLinearization<B>::ApplyJ(ConstVectorView v, VectorView u) {
  S* out = u.data();
  ForEachView([&](Unit& unit) {
    const Index values = unit.shape.NumValues();
    unit.view.ApplyJ(model_, v.data(), out, *workspace_);
    ClearMasked<B>(unit.target->mask, VectorView{out, values});
    out += values;
  });
}

template <Backend B>
void SplatLinearization<B>::ApplyJT(ConstVectorView u, VectorView g) {
  B().Fill(0, g);
  const S* in = u.data();
  ForEachView([&](Unit& unit) {
    const Index values = unit.shape.NumValues();
    const S* counted = in;
    if (unit.target->mask.size() > 0) {
      const VectorView copy = scratch_->weighted_work.view().subspan(0, values);
      B().Copy(ConstVectorView{in, values}, copy);
      ClearMasked<B>(unit.target->mask, copy);
      counted = copy.data();
    }
    unit.view.AddJT(model_, unit.image.data(), counted, g.data(), *workspace_);
    in += values;
  });
}

template <Backend B>
void SplatLinearization<B>::ApplyW(ConstVectorView u, VectorView Wu) {
  Index at = 0;
  ForEachView([&](Unit& unit) {
    const Index values = unit.shape.NumValues();
    loss_->ApplyW(unit.loss, u.subspan(at, values), Wu.subspan(at, values));
    Scale(Wu.subspan(at, values));
    at += values;
  });
}

template <Backend B>
void SplatLinearization<B>::ApplyH(ConstVectorView v, VectorView Hv) {
  B().Fill(0, Hv);
  const auto work = [](const Unit& unit, Vector& images) { return images.view().subspan(0, unit.shape.NumValues()); };
  if (options_.jacobian != JacobianKind::kOnTheFly) {
    for (Unit& unit : scratch_->units) {
      const VectorView d_image = work(unit, scratch_->image_work);
      unit.view.ApplyJ(model_, v.data(), d_image.data(), *workspace_);
      AddJTW(unit, d_image, work(unit, scratch_->weighted_work), Hv);
    }
    return;
  }
  // A view built for this product alone is rendered in the same pass.
  for (const TargetView<B>* view : views_) {
    Unit& unit = scratch_->units.front();
    Project(*view, unit);
    const VectorView d_image = work(unit, scratch_->image_work), weighted = work(unit, scratch_->weighted_work);
    unit.view.RenderAndApplyJ(model_, v.data(), unit.image.data(), d_image.data(), *workspace_);
    LinearizeLoss(unit, weighted);
    AddJTW(unit, d_image, weighted, Hv);
  }
}

template <Backend B>
void SplatLinearization<B>::AddJTW(const Unit& unit, VectorView d_image, VectorView weighted, VectorView Hv) {
  ClearMasked<B>(unit.target->mask, d_image);
  loss_->ApplyW(unit.loss, d_image, weighted);
  ClearMasked<B>(unit.target->mask, weighted);
  Scale(weighted);
  unit.view.AddJT(model_, unit.image.data(), weighted.data(), Hv.data(), *workspace_);
}

template <Backend B>
void SplatLinearization<B>::Gradient(VectorView g) {
  if (gradient_.empty()) BuildViews();
  B().Copy(gradient_, g);
  gradient_ = {};  // usually requested only once
}

template <Backend B>
void SplatLinearization<B>::RightHandSide(VectorView d) {
  if (rhs_.empty()) BuildViews();
  B().Copy(rhs_, d);
  rhs_ = {};
}

template <Backend B>
void SplatLinearization<B>::SquaredGradients(VectorView squares) {
  VESTA_CHECK(options_.is_part, "SquaredGradients is only for a problem with options.is_part");
  if (rhs_.empty()) BuildViews();
  B().Copy(rhs_, squares);
  rhs_ = {};
}

template <Backend B>
void SplatLinearization<B>::RightHandSideOf(Index units, ConstVectorView gradient, VectorView squares) const {
  ForEach<typename B::Space>(num_parameters(), kGrain,
                             ShrunkGradient<S>{static_cast<S>(options_.gradient_shrinkage), static_cast<S>(units),
                                               gradient.data(), squares.data()});
}

template <Backend B>
void SplatLinearization<B>::AddGram(S* blocks, S* sh_diagonal) {
  ForEachView([&](Unit& unit) {
    const VectorView omega = scratch_->weighted_work.view().subspan(0, unit.shape.NumValues());
    B().Axpby(scale_, unit.loss.diagonal, 0.0, omega);
    unit.view.AddGram(model_, unit.image.data(), omega.data(), blocks, sh_diagonal, *workspace_);
  });
  // The largest buffers of the workspace, unused until the next x.
  workspace_->pair_grams = {}, workspace_->splat_grams = {};
}

template <Backend B>
void SplatLinearization<B>::DiagJTJ(VectorView d) {
  if (grams_.empty()) {
    grams_.Start(model_);
    AddGram(grams_.blocks(), grams_.sh_diagonal());
  }
  grams_.CopyDiagonal(d);
  if (options_.is_part) grams_.Release();  // otherwise the Gram matrices of all parts would be in memory
}

template <Backend B>
std::vector<BlockGroup> SplatLinearization<B>::block_groups() const {
  return SplatBlockGroups(model_);
}

template <Backend B>
void SplatLinearization<B>::BlockGram(BlockDiagonal<B>& blocks) {
  if (grams_.empty()) {
    AddGram(blocks.values(0).data(), blocks.values(1).data());
    return;
  }
  grams_.CopyBlocks(blocks);
  grams_.Release();  // requested again only after a rejected step
}

}  // namespace vesta::gs
