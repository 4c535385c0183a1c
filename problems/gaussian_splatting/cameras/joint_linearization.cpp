#include "problems/gaussian_splatting/cameras/joint_linearization.h"

#include <algorithm>

#include "kernels/core/for_each.h"
#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/image_products.h"
#include "problems/gaussian_splatting/cameras/joint_reduced.h"
#include "problems/gaussian_splatting/lm/view_agreement.h"
#include "problems/gaussian_splatting/model/masked_loss.h"

namespace vesta::gs {
namespace {

constexpr Index kGrain = 16384;  // parameters

// body(channel, place) for every value of a planar image.
template <class S, class Body>
void ForChannels(HostSpan<S> image, const Body& body) {
  const Index plane = image.size() / ImageShape::kChannels;
  for (int c = 0; c < ImageShape::kChannels; ++c) {
    ParallelFor(plane, kImageGrain, [&](Index i) { body(c, c * plane + i); });
  }
}

template <class S>
std::array<S, 3> GainsOf(const ViewUnknowns& unknowns) {
  const auto& gain = unknowns.color.gain;
  return {static_cast<S>(gain[0]), static_cast<S>(gain[1]), static_cast<S>(gain[2])};
}

template <class S>
splat::PoseTangent PoseOf(HostSpan<const S> step) {
  splat::PoseTangent xi;
  for (int k = 0; k < splat::kPoseTangent; ++k) xi.v[k] = static_cast<double>(step[k]);
  return xi;
}

}  // namespace

template <class S>
JointLinearization<S>::JointLinearization(const JointProblemOptions& options, const JointLayout& layout, ConstView x,
                                          std::span<const TargetView<B>> views,
                                          std::shared_ptr<JointScratch<S>> scratch)
    : options_(options),
      layout_(layout),
      x_(x),
      model_(x.data(), options.splats, options.splats.sh_degree),
      views_(views),
      scratch_(std::move(scratch)) {
  for (const TargetView<B>& view : views_) num_values_ += view.shape().NumValues();
  if (!is_part()) MakeUnits();
}

template <class S>
void JointLinearization<S>::MakeUnits() {
  const Index n = layout_.splats;
  units_.resize(views_.size());
  gradient_ = HostBuffer<S>(num_parameters());
  const bool steers = has_own_descent();
  HostBuffer<S> of_view;
  if (steers) of_view.Resize(num_parameters()), descent_ = HostBuffer<S>(n);
  HostBuffer<S> priors(num_priors());
  for (Index v = 0; v < layout_.views; ++v) {
    JointUnit<S>& unit = units_[static_cast<std::size_t>(v)];
    const View image_gradient = scratch_->Image(views_[static_cast<std::size_t>(v)].shape().NumValues());
    Build(v, unit, image_gradient);
    const View g = steers ? of_view.view() : gradient_.view();
    AddViewJT(v, image_gradient, g);
    std::transform(unit.prior.begin(), unit.prior.end(), priors.data(), [](double r) { return static_cast<S>(r); });
    AddPriorJT(v, priors.data(), g);
    if (!steers) continue;
    ForEach<Host>(n, kGrain, AddViewGradient<S>{of_view.data(), gradient_.data(), descent_.data()});
    const View own = layout_.StepOf(gradient_.view(), v);
    std::copy_n(layout_.StepOf(g, v).data(), own.size(), own.data());
  }
  if (steers && !is_part()) DescentOfSplats(layout_.views, gradient_, descent_);
}

template <class S>
void JointLinearization<S>::DescentOfSplats(Index units, ConstView gradient, View squares) const {
  ForEach<Host>(layout_.splats, kGrain,
                AgreedDescent<S>{static_cast<S>(options_.splats.view_agreement), static_cast<S>(units), gradient.data(),
                                 squares.data()});
}

template <class S>
void JointLinearization<S>::Build(Index v, JointUnit<S>& unit, View image_gradient) {
  const TargetView<B>& target = views_[static_cast<std::size_t>(v)];
  unit.target = &target;
  unit.unknowns = layout_.UnknownsOf(x_, v);
  unit.view.Build(model_, Moved(target.camera, unit.unknowns.motion), options_.splats.background.data(),
                  scratch_->workspace);
  unit.rendered.ResizeForOverwrite(target.shape().NumValues());
  unit.view.Render(unit.rendered.data());
  const View shown = scratch_->Weighted(unit.values());
  B().Copy(unit.rendered, shown);
  unit.unknowns.color.Apply(shown);
  LinearizeLoss(scratch_->loss, target, shown, image_gradient, unit.W);
  unit.prior = options_.prior.Residuals(unit.unknowns, layout_.free, unit.values());
  unit.prior_jacobian = options_.prior.Jacobian(unit.unknowns, layout_.free, unit.values());
}

template <class S>
auto JointLinearization<S>::residuals() const -> ConstView {
  if (residuals_.empty()) {
    VESTA_CHECK(!units_.empty(), "the residuals of a part that was not looked at");
    residuals_.ResizeForOverwrite(num_residuals());
    Index at = 0, prior = num_values_;
    for (const JointUnit<S>& unit : units_) {
      const View part = residuals_.view().subspan(at, unit.values());
      B().Copy(unit.rendered, part);
      unit.unknowns.color.Apply(part);
      B().Axpby(-1.0, unit.target->truth, 1.0, part);
      at += unit.values();
      for (const double r : unit.prior) residuals_[prior++] = static_cast<S>(r);
    }
  }
  return residuals_.view();
}

template <class S>
void JointLinearization<S>::ApplySplatJ(const JointUnit<S>& unit, const S* v, View d_image) {
  unit.view.ApplyJ(model_, v, d_image.data(), scratch_->workspace);
  const std::array<S, 3> gain = GainsOf<S>(unit.unknowns);
  ForChannels(d_image, [&](int c, Index i) { d_image[i] *= gain[static_cast<std::size_t>(c)]; });
  ClearLeftOut<B>(unit.target->mask, d_image);
}

template <class S>
void JointLinearization<S>::AddSplatJT(const JointUnit<S>& unit, View u, S* g) {
  ClearLeftOut<B>(unit.target->mask, u);
  const std::array<S, 3> gain = GainsOf<S>(unit.unknowns);
  ForChannels(u, [&](int c, Index i) { u[i] *= gain[static_cast<std::size_t>(c)]; });
  unit.view.AddJT(model_, unit.rendered.data(), u.data(), g, scratch_->workspace);
}

template <class S>
void JointLinearization<S>::ApplyViewJ(Index v, ConstView step, View d_image) {
  const JointUnit<S>& unit = units_[static_cast<std::size_t>(v)];
  const ConstView own = layout_.StepOf(step, v);
  if (layout_.free.pose) {
    ApplyModelAndPoseJ(unit.view, model_, step.data(), PoseOf(own), d_image.data(), scratch_->workspace);
  } else {
    unit.view.ApplyJ(model_, step.data(), d_image.data(), scratch_->workspace);
  }
  const std::array<S, 3> gain = GainsOf<S>(unit.unknowns);
  std::array<S, 3> d_gain{}, d_offset{};
  for (int c = 0; layout_.free.color && c < ImageShape::kChannels; ++c) {
    d_gain[static_cast<std::size_t>(c)] = own[layout_.free.Gain(c)];
    d_offset[static_cast<std::size_t>(c)] = own[layout_.free.Offset(c)];
  }
  ForChannels(d_image, [&](int channel, Index i) {
    const auto c = static_cast<std::size_t>(channel);
    d_image[i] = gain[c] * d_image[i] + (d_gain[c] * unit.rendered[i] + d_offset[c]);
  });
  ClearLeftOut<B>(unit.target->mask, d_image);
}

template <class S>
void JointLinearization<S>::AddViewJT(Index v, View u, View g) {
  const JointUnit<S>& unit = units_[static_cast<std::size_t>(v)];
  ClearLeftOut<B>(unit.target->mask, u);
  const View own = layout_.StepOf(g, v);
  const Index plane = unit.values() / ImageShape::kChannels;
  for (int c = 0; layout_.free.color && c < ImageShape::kChannels; ++c) {
    const S* channel = u.data() + c * plane;
    own[layout_.free.Gain(c)] += static_cast<S>(Dot(unit.rendered.data() + c * plane, channel, plane));
    own[layout_.free.Offset(c)] += static_cast<S>(Sum(channel, plane));
  }
  AddSplatJT(unit, u, g.data());
  if (!layout_.free.pose) return;
  // What the adjoint pass has left: the cotangents of the splats.
  const splat::PoseTangent xi = PoseCotangent(unit.view, model_, scratch_->workspace.splat_sums.data());
  for (int k = 0; k < splat::kPoseTangent; ++k) own[k] += static_cast<S>(xi.v[k]);
}

template <class S>
void JointLinearization<S>::ApplyPriorJ(Index v, ConstView step, S* out) const {
  const std::vector<double>& J = units_[static_cast<std::size_t>(v)].prior_jacobian;
  const ConstView own = layout_.StepOf(step, v);
  for (Index i = 0; i < own.size(); ++i) {
    double sum = 0;
    for (Index j = 0; j < own.size(); ++j) {
      sum += J[static_cast<std::size_t>(i * own.size() + j)] * static_cast<double>(own[j]);
    }
    out[i] = static_cast<S>(sum);
  }
}

template <class S>
void JointLinearization<S>::AddPriorJT(Index v, const S* u, View g) const {
  const std::vector<double>& J = units_[static_cast<std::size_t>(v)].prior_jacobian;
  const View own = layout_.StepOf(g, v);
  for (Index j = 0; j < own.size(); ++j) {
    double sum = 0;
    for (Index i = 0; i < own.size(); ++i) {
      sum += J[static_cast<std::size_t>(i * own.size() + j)] * static_cast<double>(u[i]);
    }
    own[j] += static_cast<S>(sum);
  }
}

template <class S>
void JointLinearization<S>::ApplyJ(ConstView v, View u) {
  EnsureUnits();
  const Index n = layout_.free.num_tangent();
  Index at = 0;
  for (Index i = 0; i < layout_.views; ++i) {
    const Index values = units_[static_cast<std::size_t>(i)].values();
    ApplyViewJ(i, v, u.subspan(at, values));
    ApplyPriorJ(i, v, u.data() + num_values_ + i * n);
    at += values;
  }
}

template <class S>
void JointLinearization<S>::ApplyJT(ConstView u, View g) {
  EnsureUnits();
  const Index n = layout_.free.num_tangent();
  B().Fill(0, g);
  Index at = 0;
  for (Index i = 0; i < layout_.views; ++i) {
    const View work = scratch_->Image(units_[static_cast<std::size_t>(i)].values());
    B().Copy(u.subspan(at, work.size()), work);
    AddViewJT(i, work, g);
    AddPriorJT(i, u.data() + num_values_ + i * n, g);
    at += work.size();
  }
}

template <class S>
void JointLinearization<S>::ApplyW(ConstView u, View Wu) {
  EnsureUnits();
  Index at = 0;
  for (const JointUnit<S>& unit : units_) {
    ApplyW(unit, u.subspan(at, unit.values()), Wu.subspan(at, unit.values()));
    at += unit.values();
  }
  B().Copy(u.subspan(at, num_priors()), Wu.subspan(at, num_priors()));
}

template <class S>
void JointLinearization<S>::ApplyH(ConstView v, View Hv) {
  EnsureUnits();
  B().Fill(0, Hv);
  HostBuffer<S> prior(layout_.free.num_tangent());
  for (Index i = 0; i < layout_.views; ++i) {
    const JointUnit<S>& unit = units_[static_cast<std::size_t>(i)];
    const View d_image = scratch_->Image(unit.values()), weighted = scratch_->Weighted(unit.values());
    ApplyViewJ(i, v, d_image);
    ApplyW(unit, d_image, weighted);
    AddViewJT(i, weighted, Hv);
    ApplyPriorJ(i, v, prior.data());
    AddPriorJT(i, prior.data(), Hv);
  }
}

template <class S>
void JointLinearization<S>::Gradient(View g) {
  if (gradient_.empty()) MakeUnits();
  B().Copy(gradient_, g);
  if (is_part()) gradient_ = {};
}

template <class S>
void JointLinearization<S>::Descent(View d) {
  B().Axpby(-1.0, gradient_, 0.0, d);
  if (has_own_descent()) B().Copy(descent_, d.subspan(0, layout_.splats));
}

template <class S>
void JointLinearization<S>::SquaredGradients(View squares) {
  VESTA_CHECK(is_part(), "the squares of a problem that is no part");
  if (descent_.empty()) MakeUnits();
  B().Fill(0, squares);
  B().Copy(descent_, squares.subspan(0, layout_.splats));
  descent_ = {};
}

template <class S>
void JointLinearization<S>::DescentOf(Index units, ConstView gradient, View squares) const {
  const Index n = layout_.splats, views = squares.size() - n;
  DescentOfSplats(units, gradient, squares);
  B().Axpby(-1.0, gradient.subspan(n, views), 0.0, squares.subspan(n, views));
}

template <class S>
const SplatGrams<CpuBackend<S>>& JointLinearization<S>::Grams() {
  if (!grams_.empty()) return grams_;
  EnsureUnits();
  grams_.Start(model_, options_.splats.sh_blocks);
  for (const JointUnit<S>& unit : units_) {
    const View omega = scratch_->Image(unit.values());
    const std::array<S, 3> gain = GainsOf<S>(unit.unknowns);
    ForChannels(omega, [&](int channel, Index i) {
      const S factor = gain[static_cast<std::size_t>(channel)];
      omega[i] = factor * factor * unit.W.diagonal[i];
    });
    unit.view.AddGram(model_, unit.rendered.data(), omega.data(), grams_.blocks(), grams_.sh_diagonal(),
                      scratch_->workspace, grams_.sh_blocks());
  }
  scratch_->workspace.pair_grams = {},
  scratch_->workspace.splat_grams = {};  // the largest of the workspace, and idle until the next x
  return grams_;
}

template <class S>
const std::vector<double>& JointLinearization<S>::MakeCurvature(JointUnit<S>& unit) {
  if (!unit.curvature.empty()) return unit.curvature;
  const ViewColumns<B> columns = ColumnsOf(
      layout_.free, unit.unknowns.color, *unit.target, unit.rendered.view(),
      MovesOf<B>(layout_.free, *unit.target, unit.view, model_, unit.rendered.view(), scratch_->workspace).view());
  unit.curvature = WeightedGram(columns, scratch_->loss, unit.W, options_.eliminate_views ? &unit.weighted : nullptr);
  const auto n = static_cast<std::size_t>(layout_.free.num_tangent());
  const std::vector<double>& J = unit.prior_jacobian;
  for (std::size_t row = 0; row < n; ++row) {
    for (std::size_t col = 0; col < n; ++col) {
      for (std::size_t k = 0; k < n; ++k) unit.curvature[row * n + col] += J[k * n + row] * J[k * n + col];
    }
  }
  return unit.curvature;
}

template <class S>
void JointLinearization<S>::DiagJTJ(View d) {
  Grams().CopyDiagonal(d.subspan(0, layout_.splats));
  const auto n = static_cast<std::size_t>(layout_.free.num_tangent());
  for (std::size_t v = 0; v < units_.size(); ++v) {
    const View own = layout_.StepOf(d, static_cast<Index>(v));
    const std::vector<double>& H = CurvatureOf(v);
    for (std::size_t k = 0; k < n; ++k) own[static_cast<Index>(k)] = static_cast<S>(H[k * n + k]);
  }
  if (is_part()) ReleaseGrams();  // others' would be held beside them
}

template <class S>
std::vector<BlockGroup> JointLinearization<S>::block_groups() const {
  return BlockGroupsOf(options_, layout_);
}

template <class S>
void JointLinearization<S>::BlockGram(BlockDiagonal<B>& blocks) {
  Grams().CopyBlocks(blocks);
  const auto values = blocks.values(static_cast<int>(blocks.groups().size()) - 1);
  for (std::size_t v = 0; v < units_.size(); ++v) {
    FillBlock(CurvatureOf(v), layout_.free.num_tangent(), static_cast<Index>(v), layout_.views, values);
  }
  if (!options_.eliminate_views) ReleaseGrams();  // nobody asks again unless a step is refused
}

template <class S>
std::unique_ptr<ReducedSystem<CpuBackend<S>>> JointLinearization<S>::MakeReducedSystem() {
  EnsureUnits();
  return options_.eliminate_views ? std::make_unique<JointReducedSystem<S>>(*this) : nullptr;
}

template class JointLinearization<float>;
template class JointLinearization<double>;

}  // namespace vesta::gs
