// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/derivatives/view_problem.h"

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "splatting/cameras/derivatives/view_linearization.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::gs {

template <class S>
ViewProblem<S>::ViewProblem(const ViewProblemOptions& options, const splat::Model<S>& model,
                            const TargetView<CpuBackend<S>>& target)
    : options_(options), model_(model), target_(target), loss_(std::make_shared<PhotometricLoss<S>>(options.weights)) {
  VESTA_CHECK(options.free.num_tangent() > 0, "a view with nothing to find");
  VESTA_CHECK(!options.free.lens, "a lens, which a view alone does not show");
  VESTA_CHECK(target.truth.size() == target.shape().NumValues(), "a truth image of {} values for a view of {} x {}",
              target.truth.size(), target.camera.width, target.camera.height);
  image_.ResizeForOverwrite(target.truth.size());
}

template <class S>
void ViewProblem<S>::Build(const ViewUnknowns& unknowns) {
  view_.Build(model_, AsFound(target_.camera, unknowns), options_.background.data(), workspace_);
}

template <class S>
Index ViewProblem<S>::CountSeen(ConstVectorView x) {
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
  HostBuffer<S> moves = MovesOf<CpuBackend<S>>(options_.free, view_, model_, workspace_);
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
