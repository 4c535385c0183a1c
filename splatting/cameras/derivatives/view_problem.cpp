// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/derivatives/view_problem.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "splatting/cameras/derivatives/image_products.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::gs {
namespace {

template <class From, class To>
void Convert(HostSpan<From> from, HostSpan<To> to) {
  ParallelFor(from.size(), kImageGrain, [&](Index i) { to[i] = static_cast<To>(from[i]); });
}

}  // namespace

template <class S>
ViewLinearization<S>::ViewLinearization(const FreeUnknowns& free, const AffineColor& color,
                                        const TargetView<CpuBackend<S>>& target, HostBuffer<S>&& rendered,
                                        HostBuffer<S>&& moves, std::shared_ptr<PhotometricLoss<S>> loss)
    : columns_(ColumnsOf<CpuBackend<S>>(free, color, target, rendered.view(), moves.view())), loss_(std::move(loss)) {
  moves = {};
  const Index n = num_residuals();
  HostBuffer<S> shown = std::move(rendered), image_gradient(n);
  color.Apply(shown.view());
  // J is zero at masked pixels, so W needs no mask.
  LinearizeLoss(*loss_, target, shown.view(), image_gradient.view(), curvature_);
  residuals_.ResizeForOverwrite(n);
  ParallelFor(n, kImageGrain,
              [&](Index i) { residuals_[i] = static_cast<double>(shown[i]) - static_cast<double>(target.truth[i]); });
  gradient_.resize(static_cast<std::size_t>(num_parameters()));
  columns_.Project(image_gradient.data(), gradient_.data());
  h_ = WeightedGram(columns_, *loss_, curvature_);
}

template <class S>
void ViewLinearization<S>::ApplyJ(ConstVectorView v, VectorView u) {
  std::fill(u.begin(), u.end(), 0.0);
  columns_.Add(1, v.data(), u.data());
}

template <class S>
void ViewLinearization<S>::ApplyJT(ConstVectorView u, VectorView g) {
  columns_.Project(u.data(), g.data());
}

template <class S>
void ViewLinearization<S>::ApplyW(ConstVectorView u, VectorView Wu) {
  HostBuffer<S> in(u.size()), out(u.size());
  Convert(u, in.view());
  loss_->ApplyW(curvature_, in, out);
  Convert(out.view(), Wu);
}

template <class S>
void ViewLinearization<S>::ApplyH(ConstVectorView v, VectorView Hv) {
  for (int i = 0; i < num_parameters(); ++i) {
    Hv[i] = 0;
    for (int j = 0; j < num_parameters(); ++j) Hv[i] += H(i, j) * v[j];
  }
}

template <class S>
void ViewLinearization<S>::Gradient(VectorView g) {
  std::copy(gradient_.begin(), gradient_.end(), g.begin());
}

template <class S>
void ViewLinearization<S>::DiagJTJ(VectorView d) {
  for (int i = 0; i < num_parameters(); ++i) d[i] = H(i, i);
}

template <class S>
void ViewLinearization<S>::BlockGram(BlockDiagonal<CpuBackend<double>>& blocks) {
  FillBlock(h_, columns_.free().num_tangent(), 0, 1, blocks.values(0));
}

template class ViewLinearization<float>;
template class ViewLinearization<double>;

template <class S>
ViewProblem<S>::ViewProblem(const ViewProblemOptions& options, const splat::Model<S>& model,
                            const TargetView<CpuBackend<S>>& target)
    : options_(options), model_(model), target_(target), loss_(std::make_shared<PhotometricLoss<S>>(options.weights)) {
  VESTA_CHECK(options.free.num_tangent() > 0, "a view without free unknowns");
  VESTA_CHECK(!options.free.lens, "a free lens: one view does not determine it");
  VESTA_CHECK(target.truth.size() == target.shape().NumValues(), "a truth image of {} values for a view of {} x {}",
              target.truth.size(), target.camera.width, target.camera.height);
  image_.ResizeForOverwrite(target.truth.size());
}

template <class S>
void ViewProblem<S>::Build(const ViewUnknowns& unknowns) {
  view_.Build(model_, AsFound(target_.camera, unknowns), options_.background.data(), workspace_);
}

template <class S>
Index ViewProblem<S>::CountVisible(ConstVectorView x) {
  Build(Unpack(x));
  return view_.num_splats();
}

template <class S>
double ViewProblem<S>::Cost(ConstVectorView x) {
  const ViewUnknowns unknowns = Unpack(x);
  Build(unknowns);
  view_.Render(image_.data());
  unknowns.color.Apply(image_.view());
  return EvaluateLoss(*loss_, target_, image_.view()).cost;
}

template <class S>
std::unique_ptr<Linearization<CpuBackend<double>>> ViewProblem<S>::Linearize(ConstVectorView x) {
  const ViewUnknowns unknowns = Unpack(x);
  Build(unknowns);
  HostBuffer<S> rendered;
  rendered.ResizeForOverwrite(target_.shape().NumValues());
  view_.Render(rendered.data());
  HostBuffer<S> moves = CameraDerivativeImages<CpuBackend<S>>(options_.free, view_, model_, workspace_);
  return std::make_unique<ViewLinearization<S>>(options_.free, unknowns.color, target_, std::move(rendered),
                                                std::move(moves), loss_);
}

template <class S>
void ViewProblem<S>::Plus(CpuBackend<double>& /*backend*/, ConstVectorView x, ConstVectorView delta, VectorView out) {
  Pack(gs::Plus(Unpack(x), options_.free, delta), out);
}

template class ViewProblem<float>;
template class ViewProblem<double>;

}  // namespace vesta::gs
