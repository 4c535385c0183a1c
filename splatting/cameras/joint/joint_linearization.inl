// SPDX-License-Identifier: Apache-2.0
// Definitions of joint_linearization.h. Include after the camera derivatives of the memory space
// (kernels/gaussian_splatting/view/camera_jacobian.h or device_camera.h).
#pragma once

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/core/for_each.h"
#include "problems/gaussian_splatting/lm/gradient_shrinkage.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "splatting/cameras/derivatives/image_products.h"
#include "splatting/cameras/derivatives/view_columns.inl"
#include "splatting/cameras/joint/joint_layout.h"
#include "splatting/cameras/joint/joint_linearization.h"
#include "splatting/cameras/unknowns/exposed_colors.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::gs {

template <Backend B>
JointLinearization<B>::JointLinearization(const JointProblemOptions& options, const JointLayout& layout,
                                          ConstVectorView x, std::span<const TargetView<B>> views,
                                          std::shared_ptr<JointScratch<B>> scratch)
    : options_(options),
      layout_(layout),
      x_(x),
      model_(x.data(), options.splats, options.splats.sh_degree),
      views_(views),
      scratch_(std::move(scratch)) {
  for (const TargetView<B>& view : views_) num_values_ += view.shape().NumValues();
  BuildViews();
}

template <Backend B>
void JointLinearization<B>::BuildViews() {
  const Index n = layout_.splats;
  units_.resize(views_.size());
  gradient_.Resize(num_parameters());
  const bool steers = has_own_right_hand_side();
  typename B::Vector of_view;
  if (steers) of_view.Resize(n), rhs_.Resize(n);
  const ConstHostTail<B> x(x_, n);
  HostTail<B> g_rest(ZeroInitialized(), gradient_.view(), n);
  std::vector<S> prior;
  for (Index v = 0; v < layout_.views; ++v) {
    JointUnit<B>& unit = units_[static_cast<std::size_t>(v)];
    const VectorView image_gradient = scratch_->Image(views_[static_cast<std::size_t>(v)].shape().NumValues());
    Build(v, x.view(), unit, image_gradient);
    AddViewJT(v, image_gradient, steers ? of_view.view() : gradient_.view(), g_rest.view());
    prior.assign(unit.prior.begin(), unit.prior.end());
    AddPriorJT(v, prior.data(), g_rest.view());
    if (steers) {
      ForEach<typename B::Space>(n, kGrain, AddViewGradient<S>{of_view.data(), gradient_.data(), rhs_.data()});
    }
  }
  g_rest.Store();
  if (!steers) return;
  ForEach<typename B::Space>(n, kGrain,
                             ShrunkGradient<S>{static_cast<S>(options_.splats.gradient_shrinkage),
                                               static_cast<S>(layout_.views), gradient_.data(), rhs_.data()});
}

template <Backend B>
void JointLinearization<B>::Build(Index v, ConstHere x, JointUnit<B>& unit, VectorView image_gradient) {
  const TargetView<B>& target = views_[static_cast<std::size_t>(v)];
  CheckTruth(target);
  unit.target = &target;
  unit.unknowns = layout_.UnknownsOf(x, v);
  unit.view.Build(model_, AsFound(target.camera, unit.unknowns), options_.splats.background.data(),
                  scratch_->workspace);
  unit.rendered.ResizeForOverwrite(target.shape().NumValues());
  unit.view.Render(unit.rendered.data());
  const VectorView shown = scratch_->Weighted(unit.values());
  B().Copy(unit.rendered, shown);
  Expose<B>(unit.unknowns.color, shown);
  LinearizeLoss<B>(scratch_->loss, target, shown, image_gradient, unit.W);
  unit.prior = options_.prior.Residuals(unit.unknowns, layout_.free, unit.values());
  unit.prior_jacobian = options_.prior.Jacobian(unit.unknowns, layout_.free, unit.values());
}

template <Backend B>
auto JointLinearization<B>::residuals() const -> ConstVectorView {
  if (residuals_.empty()) {
    residuals_.ResizeForOverwrite(num_residuals());
    HostTail<B> priors(ZeroInitialized(), residuals_.view(), num_values_);
    Index at = 0, prior = 0;
    for (const JointUnit<B>& unit : units_) {
      const VectorView part = residuals_.view().subspan(at, unit.values());
      B().Copy(unit.rendered, part);
      Expose<B>(unit.unknowns.color, part);
      B().Axpby(-1.0, unit.target->truth, 1.0, part);
      at += unit.values();
      for (const double r : unit.prior) priors.view()[prior++] = static_cast<S>(r);
    }
    priors.Store();
  }
  return residuals_.view();
}

template <Backend B>
void JointLinearization<B>::ApplySplatsJ(Index v, ConstVectorView splats, VectorView d_image) {
  const JointUnit<B>& unit = units_[static_cast<std::size_t>(v)];
  ApplyModelAndPoseJ(unit.view, model_, splats.data(), nullptr, d_image.data(), scratch_->workspace);
  ScaleChannels<B>(ChannelsOf<S>(unit.unknowns.color.gain), d_image);
  ClearMasked<B>(unit.target->mask, d_image);
}

template <Backend B>
void JointLinearization<B>::AddSplatsJT(Index v, VectorView u, VectorView g) {
  const JointUnit<B>& unit = units_[static_cast<std::size_t>(v)];
  ClearMasked<B>(unit.target->mask, u);
  ScaleChannels<B>(ChannelsOf<S>(unit.unknowns.color.gain), u);
  unit.view.AddJT(model_, unit.rendered.data(), u.data(), g.data(), scratch_->workspace);
}

template <Backend B>
void JointLinearization<B>::ApplyViewJ(Index v, ConstVectorView splats, ConstHere rest, VectorView d_image) {
  const JointUnit<B>& unit = units_[static_cast<std::size_t>(v)];
  const ConstHere own = layout_.StepOf(rest, v);
  splat::PoseTangent pose;
  for (int k = 0; k < layout_.free.pose_tangent(); ++k) pose.v[k] = static_cast<double>(own[k]);
  ApplyModelAndPoseJ(unit.view, model_, splats.data(), layout_.free.pose ? &pose : nullptr, d_image.data(),
                     scratch_->workspace);
  const Index plane = unit.values() / ImageShape::kChannels;
  ExposeChange<S> change{.gain = ChannelsOf<S>(unit.unknowns.color.gain),
                         .d_gain = {},
                         .d_offset = {},
                         .rendered = unit.rendered.data(),
                         .d_image = d_image.data(),
                         .plane = plane};
  for (int c = 0; layout_.free.color && c < ImageShape::kChannels; ++c) {
    change.d_gain.of[c] = own[layout_.free.Gain(c)];
    change.d_offset.of[c] = own[layout_.free.Offset(c)];
  }
  ForEach<typename B::Space>(plane, kExposureGrain, change);
  ClearMasked<B>(unit.target->mask, d_image);
}

template <Backend B>
void JointLinearization<B>::AddViewJT(Index v, VectorView u, VectorView g, Here g_rest) {
  const JointUnit<B>& unit = units_[static_cast<std::size_t>(v)];
  ClearMasked<B>(unit.target->mask, u);
  const Here own = layout_.StepOf(g_rest, v);
  if (layout_.free.color) {
    ImageProducts<B> products(layout_.free.color_tangent());
    AddExposureProducts<B>(unit.rendered, u, products);
    Index at = layout_.free.Gain(0);
    for (const double sum : products.Read()) own[at++] += static_cast<S>(sum);
  }
  AddSplatsJT(v, u, g);
  if (!layout_.free.pose) return;
  // The adjoint pass leaves the cotangents of the splats in the workspace.
  const splat::PoseTangent xi = PoseCotangent(unit.view, model_, scratch_->workspace.splat_sums.data());
  for (int k = 0; k < splat::kPoseTangent; ++k) own[k] += static_cast<S>(xi.v[k]);
}

template <Backend B>
void JointLinearization<B>::ApplyPriorJ(Index v, ConstHere step, S* out) const {
  const std::vector<double>& J = units_[static_cast<std::size_t>(v)].prior_jacobian;
  const ConstHere own = layout_.StepOf(step, v);
  const Index n = own.size();
  for (Index i = 0; i < n; ++i) {
    double sum = 0;
    for (Index j = 0; j < n; ++j) sum += J[static_cast<std::size_t>(i * n + j)] * static_cast<double>(own[j]);
    out[i] = static_cast<S>(sum);
  }
}

template <Backend B>
void JointLinearization<B>::AddPriorJT(Index v, const S* u, Here g) const {
  const std::vector<double>& J = units_[static_cast<std::size_t>(v)].prior_jacobian;
  const Here own = layout_.StepOf(g, v);
  const Index n = own.size();
  for (Index j = 0; j < n; ++j) {
    double sum = 0;
    for (Index i = 0; i < n; ++i) sum += J[static_cast<std::size_t>(i * n + j)] * static_cast<double>(u[i]);
    own[j] += static_cast<S>(sum);
  }
}

template <Backend B>
void JointLinearization<B>::ApplyJ(ConstVectorView v, VectorView u) {
  const Index n = layout_.free.num_tangent();
  const ConstHostTail<B> rest(v, layout_.splats);
  HostTail<B> priors(ZeroInitialized(), u, num_values_);
  Index at = 0;
  for (Index i = 0; i < layout_.views; ++i) {
    const Index values = units_[static_cast<std::size_t>(i)].values();
    ApplyViewJ(i, v, rest.view(), u.subspan(at, values));
    ApplyPriorJ(i, rest.view(), priors.view().data() + i * n);
    at += values;
  }
  priors.Store();
}

template <Backend B>
void JointLinearization<B>::ApplyJT(ConstVectorView u, VectorView g) {
  const Index n = layout_.free.num_tangent();
  B().Fill(0, g);
  const ConstHostTail<B> priors(u, num_values_);
  HostTail<B> rest(ZeroInitialized(), g, layout_.splats);
  Index at = 0;
  for (Index i = 0; i < layout_.views; ++i) {
    const VectorView work = scratch_->Image(units_[static_cast<std::size_t>(i)].values());
    B().Copy(u.subspan(at, work.size()), work);
    AddViewJT(i, work, g, rest.view());
    AddPriorJT(i, priors.view().data() + i * n, rest.view());
    at += work.size();
  }
  rest.Store();
}

template <Backend B>
void JointLinearization<B>::ApplyW(ConstVectorView u, VectorView Wu) {
  Index at = 0;
  for (const JointUnit<B>& unit : units_) {
    ApplyW(unit, u.subspan(at, unit.values()), Wu.subspan(at, unit.values()));
    at += unit.values();
  }
  B().Copy(u.subspan(at, num_priors()), Wu.subspan(at, num_priors()));
}

template <Backend B>
void JointLinearization<B>::ApplyH(ConstVectorView v, VectorView Hv) {
  B().Fill(0, Hv);
  const ConstHostTail<B> rest(v, layout_.splats);
  HostTail<B> to(ZeroInitialized(), Hv, layout_.splats);
  HostBuffer<S> prior(layout_.free.num_tangent());
  for (Index i = 0; i < layout_.views; ++i) {
    const JointUnit<B>& unit = units_[static_cast<std::size_t>(i)];
    const VectorView d_image = scratch_->Image(unit.values()), weighted = scratch_->Weighted(unit.values());
    ApplyViewJ(i, v, rest.view(), d_image);
    ApplyW(unit, d_image, weighted);
    AddViewJT(i, weighted, Hv, to.view());
    ApplyPriorJ(i, rest.view(), prior.data());
    AddPriorJT(i, prior.data(), to.view());
  }
  to.Store();
}

template <Backend B>
void JointLinearization<B>::Gradient(VectorView g) {
  B().Copy(gradient_, g);
}

template <Backend B>
void JointLinearization<B>::RightHandSide(VectorView d) {
  B().Axpby(-1.0, gradient_, 0.0, d);
  B().Copy(rhs_, d.subspan(0, layout_.splats));
}

template <Backend B>
const SplatGrams<B>& JointLinearization<B>::Grams() {
  if (!grams_.empty()) return grams_;
  grams_.Start(model_);
  for (const JointUnit<B>& unit : units_) {
    const VectorView omega = scratch_->Image(unit.values());
    B().Copy(unit.W.diagonal, omega);
    Channels<S> squared = ChannelsOf<S>(unit.unknowns.color.gain);
    for (S& gain : squared.of) gain *= gain;
    ScaleChannels<B>(squared, omega);
    unit.view.AddGram(model_, unit.rendered.data(), omega.data(), grams_.blocks(), grams_.sh_diagonal(),
                      scratch_->workspace);
  }
  scratch_->workspace.pair_grams = {},
  scratch_->workspace.splat_grams = {};  // the largest buffers of the workspace, unused until the next x
  return grams_;
}

template <Backend B>
const std::vector<double>& JointLinearization<B>::MakeCurvature(JointUnit<B>& unit) {
  if (!unit.curvature.empty()) return unit.curvature;
  const ViewColumns<B> columns =
      ColumnsOf<B>(layout_.free, unit.unknowns.color, *unit.target, unit.rendered.view(),
                   CameraDerivativeImages<B>(layout_.free, unit.view, model_, scratch_->workspace).view());
  unit.curvature =
      WeightedGram<B>(columns, scratch_->loss, unit.W, options_.eliminate_views ? &unit.weighted : nullptr);
  const auto n = static_cast<std::size_t>(layout_.free.num_tangent());
  const std::vector<double>& J = unit.prior_jacobian;
  for (std::size_t row = 0; row < n; ++row) {
    for (std::size_t col = 0; col < n; ++col) {
      for (std::size_t k = 0; k < n; ++k) unit.curvature[row * n + col] += J[k * n + row] * J[k * n + col];
    }
  }
  return unit.curvature;
}

template <Backend B>
void JointLinearization<B>::DiagJTJ(VectorView d) {
  Grams().CopyDiagonal(d.subspan(0, layout_.splats));
  HostTail<B> rest(ZeroInitialized(), d, layout_.splats);
  const Index n = layout_.free.num_tangent();
  for (std::size_t v = 0; v < units_.size(); ++v) {
    const Here own = layout_.StepOf(rest.view(), static_cast<Index>(v));
    const std::vector<double>& H = CurvatureOf(v);
    for (Index k = 0; k < n; ++k) own[k] = static_cast<S>(H[static_cast<std::size_t>(k * n + k)]);
  }
  rest.Store();
}

template <Backend B>
void JointLinearization<B>::BlockGram(BlockDiagonal<B>& blocks) {
  Grams().CopyBlocks(blocks);
  HostTail<B> values(ZeroInitialized(), blocks.values(static_cast<int>(blocks.groups().size()) - 1), 0);
  for (std::size_t v = 0; v < units_.size(); ++v) {
    FillBlock(CurvatureOf(v), layout_.free.num_tangent(), static_cast<Index>(v), layout_.views, values.view());
  }
  values.Store();
  if (!options_.eliminate_views) grams_.Release();  // only a rejected step would use them again
}

template <Backend B>
std::unique_ptr<ReducedSystem<B>> JointLinearization<B>::MakeReducedSystem() {
  return options_.eliminate_views ? std::make_unique<JointReducedSystem<B>>(*this) : nullptr;
}

}  // namespace vesta::gs
