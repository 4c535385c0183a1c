#include "problems/gaussian_splatting/lm/splat_linearization.h"

#include <algorithm>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "problems/gaussian_splatting/lm/view_agreement.h"

namespace vesta::gs {
namespace {

constexpr Index kGrain = 16384;  // entries of a vector of parameters

// v *= scale.
template <class S>
void Scale(double scale, HostSpan<S> v) {
  if (scale != 1) CpuBackend<S>().Axpby(scale, v, 0.0, v);
}

template <class S>
ImageShape ShapeOf(const TargetView<CpuBackend<S>>& target) {
  return {target.pinhole.width, target.pinhole.height};
}

}  // namespace

template <class S>
SplatLinearization<S>::SplatLinearization(const SplatProblemOptions& options, ConstView x,
                                          const std::vector<BatchView<S>>& views, double scale, int turn,
                                          std::shared_ptr<PhotometricLoss<S>> loss,
                                          std::shared_ptr<splat::ViewWorkspace<S>> workspace)
    : options_(options),
      views_(views),
      scale_(scale),
      turn_(turn),
      units_(options.jacobian == JacobianKind::kRebuild ? std::min<std::size_t>(views.size(), 1) : views.size()),
      loss_(std::move(loss)),
      workspace_(std::move(workspace)) {
  model_ = {x.data(), options.count, options.sh_degree, options.sh_degree};
  Index largest = 0;
  for (const BatchView<S>& view : views) {
    const Index values = ShapeOf(*view.target).NumValues();
    num_residuals_ += values;
    largest = std::max(largest, values);
  }
  image_work_.Resize(largest);
  weighted_work_.Resize(largest);
  MakeUnits();
}

template <class S>
void SplatLinearization<S>::MakeUnits() {
  gradient_.Resize(num_parameters());
  const bool steers = has_own_descent();
  HostBuffer<S> of_view;
  if (steers) of_view.Resize(num_parameters()), descent_.Resize(num_parameters());
  for (std::size_t i = 0; i < views_.size(); ++i) {
    Unit& unit = units_[i % units_.size()];
    const View image_gradient = image_work_.view().subspan(0, ShapeOf(*views_[i].target).NumValues());
    Build(views_[i], unit, image_gradient);
    if (options_.sample_gradient) Prepare(views_[i], unit);
    Scale(unit.scale, image_gradient);
    unit.view.AddJT(model_, unit.image.data(), image_gradient.data(), (steers ? of_view : gradient_).data(),
                    *workspace_);
    if (steers) {
      ParallelFor(num_parameters(), kGrain, AddViewGradient<S>{of_view.data(), gradient_.data(), descent_.data()});
    }
    // After the gradient, which is thereby exact.
    if (!options_.sample_gradient) Prepare(views_[i], unit);
  }
  if (steers) {
    ParallelFor(num_parameters(), kGrain,
                AgreedDescent<S>{static_cast<S>(options_.view_agreement), static_cast<S>(views_.size()),
                                 gradient_.data(), descent_.data()});
  }
}

template <class S>
void SplatLinearization<S>::Build(const BatchView<S>& from, Unit& unit, View image_gradient) const {
  Project(from, unit);
  unit.view.Render(unit.image.data());
  LinearizeLoss(unit, image_gradient);
}

template <class S>
void SplatLinearization<S>::Project(const BatchView<S>& from, Unit& unit) const {
  unit.target = from.target;
  unit.scale = scale_;
  unit.shape = ShapeOf(*from.target);
  unit.view.Build(model_, unit.target->pinhole, options_.background.data(), *workspace_);
  unit.image.ResizeForOverwrite(unit.shape.NumValues());
}

template <class S>
void SplatLinearization<S>::LinearizeLoss(Unit& unit, View image_gradient) const {
  loss_->Linearize(unit.image, unit.target->truth, unit.shape, image_gradient, unit.loss);
}

template <class S>
void SplatLinearization<S>::Prepare(const BatchView<S>& from, Unit& unit) const {
  if (options_.residual_sampling < 1) {
    const PixelSample sample = SamplePixels(options_.sampling_unit, unit.view.num_tiles(), options_.residual_sampling,
                                            options_.seed, turn_, from.index);
    unit.view.KeepRows(sample.rows);
    unit.scale *= sample.scale;
  }
  if (IsCached(options_.jacobian)) unit.view.CacheJacobian(unit.image.data(), CacheFormatOf(options_.jacobian));
}

template <class S>
template <class Body>
void SplatLinearization<S>::ForEachUnit(const Body& body) const {
  if (options_.jacobian != JacobianKind::kRebuild) {
    for (Unit& unit : units_) body(unit);
    return;
  }
  for (const BatchView<S>& view : views_) {
    Unit& unit = units_.front();
    Build(view, unit, image_work_.view().subspan(0, ShapeOf(*view.target).NumValues()));
    Prepare(view, unit);
    body(unit);
  }
}

template <class S>
typename SplatLinearization<S>::ConstView SplatLinearization<S>::residuals() const {
  if (residuals_.empty()) {
    residuals_.Resize(num_residuals_);
    Index at = 0;
    ForEachUnit([&](const Unit& unit) {
      for (Index k = 0; k < unit.image.size(); ++k) residuals_[at++] = unit.image[k] - unit.target->truth[k];
    });
  }
  return residuals_.view();
}

template <class S>
void SplatLinearization<S>::ApplyJ(ConstView v, View u) {
  S* out = u.data();
  ForEachUnit([&](Unit& unit) {
    unit.view.ApplyJ(model_, v.data(), out, *workspace_);
    out += unit.shape.NumValues();
  });
}

template <class S>
void SplatLinearization<S>::ApplyJT(ConstView u, View g) {
  std::fill(g.begin(), g.end(), S(0));
  const S* in = u.data();
  ForEachUnit([&](Unit& unit) {
    unit.view.AddJT(model_, unit.image.data(), in, g.data(), *workspace_);
    in += unit.shape.NumValues();
  });
}

template <class S>
void SplatLinearization<S>::ApplyW(ConstView u, View Wu) {
  Index at = 0;
  ForEachUnit([&](Unit& unit) {
    const Index values = unit.shape.NumValues();
    loss_->ApplyW(unit.loss, u.subspan(at, values), Wu.subspan(at, values));
    Scale(unit.scale, Wu.subspan(at, values));
    at += values;
  });
}

template <class S>
void SplatLinearization<S>::ApplyH(ConstView v, View Hv) {
  std::fill(Hv.begin(), Hv.end(), S(0));
  const auto work = [](const Unit& unit, HostBuffer<S>& images) {
    return images.view().subspan(0, unit.shape.NumValues());
  };
  if (options_.jacobian != JacobianKind::kRebuild || options_.residual_sampling < 1) {
    ForEachUnit([&](Unit& unit) {
      const View d_image = work(unit, image_work_);
      unit.view.ApplyJ(model_, v.data(), d_image.data(), *workspace_);
      AddJTW(unit, d_image, work(unit, weighted_work_), Hv);
    });
    return;
  }
  // A view that is built for this product alone is rendered along with it.
  for (const BatchView<S>& view : views_) {
    Unit& unit = units_.front();
    Project(view, unit);
    const View d_image = work(unit, image_work_), weighted = work(unit, weighted_work_);
    unit.view.RenderAndApplyJ(model_, v.data(), unit.image.data(), d_image.data(), *workspace_);
    LinearizeLoss(unit, weighted);
    AddJTW(unit, d_image, weighted, Hv);
  }
}

template <class S>
void SplatLinearization<S>::AddJTW(Unit& unit, ConstView d_image, View weighted, View Hv) {
  loss_->ApplyW(unit.loss, d_image, weighted);
  Scale(unit.scale, weighted);
  unit.view.AddJT(model_, unit.image.data(), weighted.data(), Hv.data(), *workspace_);
}

template <class S>
void SplatLinearization<S>::Gradient(View g) {
  if (gradient_.empty()) MakeUnits();
  std::copy(gradient_.begin(), gradient_.end(), g.begin());
  gradient_ = {};  // nobody asks again, as a rule
}

template <class S>
void SplatLinearization<S>::Descent(View d) {
  if (!has_own_descent()) return Base::Descent(d);
  if (descent_.empty()) MakeUnits();
  std::copy(descent_.begin(), descent_.end(), d.begin());
  descent_ = {};
}

template <class S>
void SplatLinearization<S>::AddGram(S* blocks, S* sh_diagonal, S* sh_blocks) {
  ForEachUnit([&](Unit& unit) {
    const View omega = weighted_work_.view().subspan(0, unit.shape.NumValues());
    CpuBackend<S>().Axpby(unit.scale, unit.loss.diagonal, 0.0, omega);
    unit.view.AddGram(model_, unit.image.data(), omega.data(), blocks, sh_diagonal, *workspace_, sh_blocks);
  });
  // The largest of the workspace, and idle until the next x.
  workspace_->pair_grams = {}, workspace_->splat_grams = {};
}

template <class S>
void SplatLinearization<S>::DiagJTJ(View d) {
  const Index n = model_.count;
  if (gram_blocks_.empty()) {
    gram_blocks_.Resize(PackedValues(splat::kGeometry) * n);
    gram_sh_.Resize(num_parameters() - splat::kSh * n);
    if (options_.sh_blocks) gram_sh_blocks_.Resize(PackedValues(ShCoefficients(model_.sh_degree)) * n);
    AddGram(gram_blocks_.data(), gram_sh_.data(), options_.sh_blocks ? gram_sh_blocks_.data() : nullptr);
  }
  for (int a = 0; a < splat::kGeometry; ++a) {
    std::copy_n(gram_blocks_.data() + PackedLower(a, a) * n, n, d.data() + a * n);
  }
  std::copy(gram_sh_.begin(), gram_sh_.end(), d.data() + splat::kSh * n);
}

template <class S>
std::vector<BlockGroup> SplatLinearization<S>::block_groups() const {
  return SplatBlockGroups(model_.count, model_.sh_degree, options_.sh_blocks);
}

template <class S>
void SplatLinearization<S>::BlockGram(BlockDiagonal<CpuBackend<S>>& blocks) {
  if (gram_blocks_.empty()) {
    HostBuffer<S> diagonal(options_.sh_blocks ? num_parameters() - splat::kSh * model_.count : 0);
    S* const sh = blocks.values(1).data();
    AddGram(blocks.values(0).data(), options_.sh_blocks ? diagonal.data() : sh, options_.sh_blocks ? sh : nullptr);
    return;
  }
  std::copy(gram_blocks_.begin(), gram_blocks_.end(), blocks.values(0).begin());
  const HostBuffer<S>& sh = options_.sh_blocks ? gram_sh_blocks_ : gram_sh_;
  std::copy(sh.begin(), sh.end(), blocks.values(1).begin());
  gram_blocks_ = {}, gram_sh_ = {}, gram_sh_blocks_ = {};  // nobody asks again unless a step is refused
}

template class SplatLinearization<float>;
template class SplatLinearization<double>;

}  // namespace vesta::gs
