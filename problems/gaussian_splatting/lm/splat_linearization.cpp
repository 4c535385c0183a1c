#include "problems/gaussian_splatting/lm/splat_linearization.h"

#include <algorithm>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"

namespace vesta::gs {
namespace {

constexpr int kBlockValues = splat::kGeometry * (splat::kGeometry + 1) / 2;

}  // namespace

template <class S>
SplatLinearization<S>::SplatLinearization(const SplatProblemOptions& options, ConstView x,
                                          const std::vector<const TargetView<S>*>& views,
                                          std::shared_ptr<PhotometricLoss<S>> loss,
                                          std::shared_ptr<splat::ViewWorkspace<S>> workspace)
    : units_(views.size()), loss_(std::move(loss)), workspace_(std::move(workspace)), gradient_(x.size()) {
  x_.CopyFrom(x);
  model_ = {x_.data(), options.count, options.sh_degree, options.sh_degree};
  HostBuffer<S> image_gradient;
  for (std::size_t i = 0; i < views.size(); ++i) {
    Unit& unit = units_[i];
    unit.target = views[i];
    unit.shape = {unit.target->pinhole.width, unit.target->pinhole.height};
    const Index values = unit.shape.NumValues();
    num_residuals_ += values;
    if (image_work_.size() < values) image_work_.Resize(values), weighted_work_.Resize(values);
    unit.view.Build(model_, unit.target->pinhole, options.background.data(), *workspace_);
    unit.image.Resize(values);
    unit.view.Render(unit.image.data());
    image_gradient.Resize(values);
    loss_->Linearize(unit.image, unit.target->truth, unit.shape, image_gradient, unit.loss);
    unit.view.AddJT(model_, unit.image.data(), image_gradient.data(), gradient_.data(), *workspace_);
  }
}

template <class S>
typename SplatLinearization<S>::ConstView SplatLinearization<S>::residuals() const {
  if (residuals_.empty()) {
    residuals_.Resize(num_residuals_);
    Index at = 0;
    for (const Unit& unit : units_) {
      for (Index k = 0; k < unit.image.size(); ++k) residuals_[at++] = unit.image[k] - unit.target->truth[k];
    }
  }
  return residuals_.view();
}

template <class S>
void SplatLinearization<S>::ApplyJ(ConstView v, View u) {
  S* out = u.data();
  for (Unit& unit : units_) {
    unit.view.ApplyJ(model_, v.data(), out, *workspace_);
    out += unit.shape.NumValues();
  }
}

template <class S>
void SplatLinearization<S>::ApplyJT(ConstView u, View g) {
  std::fill(g.begin(), g.end(), S(0));
  const S* in = u.data();
  for (Unit& unit : units_) {
    unit.view.AddJT(model_, unit.image.data(), in, g.data(), *workspace_);
    in += unit.shape.NumValues();
  }
}

template <class S>
void SplatLinearization<S>::ApplyW(ConstView u, View Wu) {
  Index at = 0;
  for (Unit& unit : units_) {
    const Index values = unit.shape.NumValues();
    loss_->ApplyW(unit.loss, u.subspan(at, values), Wu.subspan(at, values));
    at += values;
  }
}

template <class S>
void SplatLinearization<S>::ApplyH(ConstView v, View Hv) {
  std::fill(Hv.begin(), Hv.end(), S(0));
  for (Unit& unit : units_) {
    const Index values = unit.shape.NumValues();
    const View d_image = image_work_.view().subspan(0, values), weighted = weighted_work_.view().subspan(0, values);
    unit.view.ApplyJ(model_, v.data(), d_image.data(), *workspace_);
    loss_->ApplyW(unit.loss, d_image, weighted);
    unit.view.AddJT(model_, unit.image.data(), weighted.data(), Hv.data(), *workspace_);
  }
}

template <class S>
void SplatLinearization<S>::Gradient(View g) {
  std::copy(gradient_.begin(), gradient_.end(), g.begin());
}

template <class S>
void SplatLinearization<S>::EnsureGram() {
  if (!gram_blocks_.empty()) return;
  gram_blocks_.Resize(kBlockValues * model_.count);
  gram_sh_.Resize(x_.size() - splat::kSh * model_.count);
  for (Unit& unit : units_) {
    unit.view.AddGram(model_, unit.image.data(), unit.loss.diagonal.data(), gram_blocks_.data(), gram_sh_.data(),
                      *workspace_);
  }
}

template <class S>
void SplatLinearization<S>::DiagJTJ(View d) {
  EnsureGram();
  for (int a = 0; a < splat::kGeometry; ++a) {
    std::copy_n(gram_blocks_.data() + PackedLower(a, a) * model_.count, model_.count, d.data() + a * model_.count);
  }
  std::copy(gram_sh_.begin(), gram_sh_.end(), d.data() + splat::kSh * model_.count);
}

template <class S>
std::vector<BlockGroup> SplatLinearization<S>::block_groups() const {
  const Index n = model_.count;
  return {{.size = splat::kGeometry, .count = n, .offset = 0, .component_stride = n, .block_stride = 1},
          {.size = 1, .count = x_.size() - splat::kSh * n, .offset = splat::kSh * n}};
}

template <class S>
void SplatLinearization<S>::BlockGram(BlockDiagonal<CpuBackend<S>>& blocks) {
  EnsureGram();
  std::copy(gram_blocks_.begin(), gram_blocks_.end(), blocks.values(0).begin());
  std::copy(gram_sh_.begin(), gram_sh_.end(), blocks.values(1).begin());
}

template class SplatLinearization<float>;
template class SplatLinearization<double>;

}  // namespace vesta::gs
