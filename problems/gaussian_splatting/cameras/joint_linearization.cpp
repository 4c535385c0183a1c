#include "problems/gaussian_splatting/cameras/joint_linearization.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/core/for_each.h"
#include "kernels/gaussian_splatting/lens_jacobian.h"
#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/image_products.h"
#include "problems/gaussian_splatting/cameras/joint_reduced.h"
#include "problems/gaussian_splatting/cameras/joint_view.h"
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
  if (steers) std::copy_n(of_view.data() + n, layout_.shared() - n, gradient_.data() + n);
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
  CheckTruth(target);
  unit.target = &target;
  unit.unknowns = layout_.UnknownsOf(x_, v);
  unit.unbent_by = BendOf(options_, layout_, v);
  unit.view.Build(model_, AsFound(target.camera, unit.unknowns), options_.splats.background.data(),
                  scratch_->workspace);
  unit.rendered.ResizeForOverwrite(target.shape().NumValues());
  unit.view.Render(unit.rendered.data());
  const View shown = scratch_->Weighted(unit.values());
  B().Copy(unit.rendered, shown);
  ShowAsFound(unit.unknowns, unit.unbent_by, target, *scratch_, shown);
  LinearizeLoss(scratch_->loss, target, shown, image_gradient, unit.W);
  const ImageOfPrior of_image{unit.values(), CornerOf(target.camera)};
  unit.prior = options_.prior.Residuals(unit.unknowns, layout_.free, of_image);
  unit.prior_jacobian = options_.prior.Jacobian(unit.unknowns, layout_.free, of_image);
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
      ShowAsFound(unit.unknowns, unit.unbent_by, *unit.target, *scratch_, part);
      B().Axpby(-1.0, unit.target->truth, 1.0, part);
      at += unit.values();
      for (const double r : unit.prior) residuals_[prior++] = static_cast<S>(r);
    }
  }
  return residuals_.view();
}

template <class S>
void JointLinearization<S>::ApplyImageJ(Index v, ConstView step, const splat::PoseTangent* pose, View d_image) {
  const JointUnit<S>& unit = units_[static_cast<std::size_t>(v)];
  splat::LensTangent lens;
  const ConstView of_lens = layout_.LensStepOf(step, v);
  for (int k = 0; k < layout_.free.pinhole_tangent(); ++k) lens.v[k] = static_cast<double>(of_lens[k]);
  ApplyModelAndCameraJ(unit.view, model_, step.data(), pose, layout_.free.lens ? &lens : nullptr, d_image.data(),
                       scratch_->workspace);
}

template <class S>
void JointLinearization<S>::AddBendJ(Index v, ConstView step, View d_image) {
  const JointUnit<S>& unit = units_[static_cast<std::size_t>(v)];
  const ConstView of_lens = layout_.LensStepOf(step, v);
  for (int k = 0; unit.unbent_by && k < kRadialTangent; ++k) {
    const View column = scratch_->Column(unit.values());
    PhotographBend(*unit.target, k, column);
    B().Axpby(static_cast<double>(of_lens[layout_.free.Radial(k)]), column, 1.0, d_image);
  }
}

template <class S>
void JointLinearization<S>::ApplySharedJ(Index v, ConstView step, View d_image) {
  const JointUnit<S>& unit = units_[static_cast<std::size_t>(v)];
  ApplyImageJ(v, step, nullptr, d_image);
  const std::array<S, 3> gain = GainsOf<S>(unit.unknowns);
  ForChannels(d_image, [&](int c, Index i) { d_image[i] *= gain[static_cast<std::size_t>(c)]; });
  AddBendJ(v, step, d_image);
  ClearLeftOut<B>(unit.target->mask, d_image);
}

template <class S>
void JointLinearization<S>::AddSharedJT(Index v, View u, View g) {
  const JointUnit<S>& unit = units_[static_cast<std::size_t>(v)];
  const View of_lens = layout_.LensStepOf(g, v);
  ClearLeftOut<B>(unit.target->mask, u);
  for (int k = 0; unit.unbent_by && k < kRadialTangent; ++k) {
    const View column = scratch_->Column(unit.values());
    PhotographBend(*unit.target, k, column);
    of_lens[layout_.free.Radial(k)] += static_cast<S>(Dot(column.data(), u.data(), unit.values()));
  }
  const std::array<S, 3> gain = GainsOf<S>(unit.unknowns);
  ForChannels(u, [&](int c, Index i) { u[i] *= gain[static_cast<std::size_t>(c)]; });
  unit.view.AddJT(model_, unit.rendered.data(), u.data(), g.data(), scratch_->workspace);
  if (!layout_.free.lens) return;
  // What the adjoint pass has left: the cotangents of the splats.
  const splat::LensTangent lens = LensCotangent(unit.view, scratch_->workspace.splat_sums.data());
  for (int k = 0; k < layout_.free.pinhole_tangent(); ++k) of_lens[k] += static_cast<S>(lens.v[k]);
}

template <class S>
void JointLinearization<S>::ApplyViewJ(Index v, ConstView step, View d_image) {
  const JointUnit<S>& unit = units_[static_cast<std::size_t>(v)];
  const ConstView own = layout_.StepOf(step, v);
  const splat::PoseTangent pose = layout_.free.pose ? PoseOf(own) : splat::PoseTangent();
  ApplyImageJ(v, step, layout_.free.pose ? &pose : nullptr, d_image);
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
  AddBendJ(v, step, d_image);
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
  AddSharedJT(v, u, g);
  if (!layout_.free.pose) return;
  const splat::PoseTangent xi = PoseCotangent(unit.view, model_, scratch_->workspace.splat_sums.data());
  for (int k = 0; k < splat::kPoseTangent; ++k) own[k] += static_cast<S>(xi.v[k]);
}

template <class S>
void JointLinearization<S>::ApplyPriorJ(Index v, ConstView step, S* out) const {
  const std::vector<double>& J = units_[static_cast<std::size_t>(v)].prior_jacobian;
  const std::vector<double> whole = layout_.WholeStepOf(step, v);
  const std::size_t n = whole.size();
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < n; ++j) sum += J[i * n + j] * whole[j];
    out[i] = static_cast<S>(sum);
  }
}

template <class S>
void JointLinearization<S>::AddPriorJT(Index v, const S* u, View g) const {
  const std::vector<double>& J = units_[static_cast<std::size_t>(v)].prior_jacobian;
  const View own = layout_.StepOf(g, v), of_lens = layout_.LensStepOf(g, v);
  const Index n = own.size() + of_lens.size();
  for (Index j = 0; j < n; ++j) {
    double sum = 0;
    for (Index i = 0; i < n; ++i) sum += J[static_cast<std::size_t>(i * n + j)] * static_cast<double>(u[i]);
    (j < own.size() ? own[j] : of_lens[j - own.size()]) += static_cast<S>(sum);
  }
}

template <class S>
void JointLinearization<S>::AddPriorOfLens(Index v, ConstView x, View y) const {
  const std::vector<double>& J = units_[static_cast<std::size_t>(v)].prior_jacobian;
  const ConstView of_lens = layout_.LensStepOf(x, v);
  const View to = layout_.LensStepOf(y, v);
  const Index n = layout_.free.num_tangent();
  for (Index k = 0; k < of_lens.size(); ++k) {
    const Index at = layout_.free.Lens(static_cast<int>(k));  // where J is diagonal
    const double j = J[static_cast<std::size_t>(at * n + at)];
    to[k] += static_cast<S>(j * j * static_cast<double>(of_lens[k]));
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
  VESTA_CHECK(!is_part(), "the descent of a part");
  B().Axpby(-1.0, gradient_, 0.0, d);
  if (has_own_descent()) B().Copy(descent_, d.subspan(0, layout_.splats));
}

template <class S>
void JointLinearization<S>::SquaredGradients(View squares) {
  VESTA_CHECK(is_part() && has_own_descent(), "the squares of a problem that is no part, or has no descent of its own");
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
  ViewColumns<B> columns = ColumnsOf(
      layout_.free, unit.unknowns.color, *unit.target, unit.rendered.view(),
      MovesOf<B>(layout_.free, *unit.target, unit.view, model_, unit.rendered.view(), scratch_->workspace).view());
  for (int k = 0; k < layout_.free.radial_tangent(); ++k) {
    const View column = columns.image(columns.num_images() - kRadialTangent + k);
    B().Fill(0, column);
    if (unit.unbent_by) PhotographBend(*unit.target, k, column);
    ClearLeftOut<B>(unit.target->mask, column);
  }
  unit.curvature = WeightedGram(columns, scratch_->loss, unit.W, options_.eliminate_views ? &unit.weighted : nullptr);
  columns = {};  // before the copy takes its room
  if (options_.eliminate_views && layout_.free.lens) unit.weighted = unit.weighted.OwnOfView();
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
  B().Fill(0, d.subspan(layout_.splats, layout_.shared() - layout_.splats));
  const Index n = layout_.free.num_tangent();
  for (std::size_t v = 0; v < units_.size(); ++v) {
    const View own = layout_.StepOf(d, static_cast<Index>(v)), of_lens = layout_.LensStepOf(d, static_cast<Index>(v));
    const std::vector<double>& H = CurvatureOf(v);
    const auto at = [&](Index k) { return static_cast<S>(H[static_cast<std::size_t>(k * n + k)]); };
    for (Index k = 0; k < own.size(); ++k) own[k] = at(k);
    for (Index k = 0; k < of_lens.size(); ++k) of_lens[k] += at(own.size() + k);
  }
  if (is_part()) ReleaseGrams();  // others' would be held beside them
}

template <class S>
void JointLinearization<S>::BlockGram(BlockDiagonal<B>& blocks) {
  Grams().CopyBlocks(blocks);
  const int own = layout_.own().num_tangent(), all = layout_.free.num_tangent(),
            of_views = static_cast<int>(blocks.groups().size()) - 1;
  for (std::size_t v = 0; v < units_.size(); ++v) {
    const std::vector<double> block = SquareOf(CurvatureOf(v), all, 0, own);
    FillBlock(block, own, static_cast<Index>(v), layout_.views, blocks.values(of_views));
  }
  if (layout_.lenses > 0) {
    AddLensBlocks([&](Index v) { return SquareOf(CurvatureOf(static_cast<std::size_t>(v)), all, own, all); },
                  blocks.values(of_views - 1));
  }
  if (!options_.eliminate_views) ReleaseGrams();  // nobody asks again unless a step is refused
}

template <class S>
void JointLinearization<S>::AddLensBlocks(const std::function<std::vector<double>(Index)>& of_view, View values) const {
  const int n = layout_.free.lens_tangent();
  std::vector<std::vector<double>> sums(static_cast<std::size_t>(layout_.lenses),
                                        std::vector<double>(static_cast<std::size_t>(n) * static_cast<std::size_t>(n)));
  for (Index v = 0; v < layout_.views; ++v) {
    std::vector<double>& sum = sums[static_cast<std::size_t>(layout_.LensOf(v))];
    std::ranges::transform(sum, of_view(v), sum.begin(), std::plus());
  }
  for (Index lens = 0; lens < layout_.lenses; ++lens) {
    FillBlock(sums[static_cast<std::size_t>(lens)], n, lens, layout_.lenses, values);
  }
}

template <class S>
std::unique_ptr<ReducedSystem<CpuBackend<S>>> JointLinearization<S>::MakeReducedSystem() {
  EnsureUnits();
  return options_.eliminate_views ? std::make_unique<JointReducedSystem<S>>(*this) : nullptr;
}

template class JointLinearization<float>;
template class JointLinearization<double>;

}  // namespace vesta::gs
