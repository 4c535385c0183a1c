#include "problems/gaussian_splatting/lm/device_splat_linearization.h"

#include <algorithm>

#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"

namespace vesta::gs {
namespace {

using B = CudaBackend<float>;

// v *= scale.
void Scale(double scale, B::View v) {
  if (scale != 1) B().Axpby(0.0, v, scale, v);
}

}  // namespace

DeviceSplatLinearization::DeviceSplatLinearization(const SplatProblemOptions& options, ConstView x,
                                                   const std::vector<DeviceBatchView>& views, double scale, int turn,
                                                   std::shared_ptr<DevicePhotometricLoss> loss,
                                                   std::shared_ptr<splat::DeviceViewWorkspace> workspace)
    : options_(options),
      units_(views.size()),
      loss_(std::move(loss)),
      workspace_(std::move(workspace)),
      gradient_(x.size()) {
  model_ = {x.data(), options.count, options.sh_degree, options.sh_degree};
  Index largest = 0;
  for (const DeviceBatchView& view : views) largest = std::max(largest, view.target->shape().NumValues());
  image_work_.ResizeForOverwrite(largest);
  weighted_work_.ResizeForOverwrite(largest);
  for (std::size_t i = 0; i < views.size(); ++i) {
    Unit& unit = units_[i];
    unit.target = views[i].target;
    unit.scale = scale;
    unit.shape = unit.target->shape();
    const Index values = unit.shape.NumValues();
    num_residuals_ += values;
    const View image_gradient = image_work_.view().subspan(0, values);
    unit.view.Build(model_, unit.target->pinhole, options.background.data(), *workspace_);
    unit.image.ResizeForOverwrite(values);
    unit.view.Render(unit.image.data());
    loss_->Linearize(unit.image, unit.target->truth, unit.shape, image_gradient, unit.loss);
    if (options.sample_gradient) Prepare(unit, views[i].index, turn);
    Scale(unit.scale, image_gradient);
    unit.view.AddJT(model_, unit.image.data(), image_gradient.data(), gradient_.data(), *workspace_);
    // After the gradient, which is thereby exact.
    if (!options.sample_gradient) Prepare(unit, views[i].index, turn);
  }
}

void DeviceSplatLinearization::Prepare(Unit& unit, Index view, int turn) {
  if (options_.residual_sampling < 1) {
    const PixelSample sample = SamplePixels(options_.sampling_unit, unit.view.num_tiles(), options_.residual_sampling,
                                            options_.seed, turn, view);
    unit.view.KeepRows(sample.rows, *workspace_);
    unit.scale *= sample.scale;
  }
  if (IsCached(options_.jacobian)) {
    unit.view.CacheJacobian(unit.image.data(), CacheFormatOf(options_.jacobian), *workspace_);
  }
}

B::ConstView DeviceSplatLinearization::residuals() const {
  if (residuals_.empty()) {
    residuals_.ResizeForOverwrite(num_residuals_);
    Index at = 0;
    for (const Unit& unit : units_) {
      const View part = residuals_.view().subspan(at, unit.image.size());
      B().Copy(unit.image, part);
      B().Axpby(-1.0, unit.target->truth, 1.0, part);
      at += unit.image.size();
    }
  }
  return residuals_.view();
}

void DeviceSplatLinearization::ApplyJ(ConstView v, View u) {
  float* out = u.data();
  for (Unit& unit : units_) {
    unit.view.ApplyJ(model_, v.data(), out, *workspace_);
    out += unit.shape.NumValues();
  }
}

void DeviceSplatLinearization::ApplyJT(ConstView u, View g) {
  B().Fill(0, g);
  const float* in = u.data();
  for (Unit& unit : units_) {
    unit.view.AddJT(model_, unit.image.data(), in, g.data(), *workspace_);
    in += unit.shape.NumValues();
  }
}

void DeviceSplatLinearization::ApplyW(ConstView u, View Wu) {
  Index at = 0;
  for (Unit& unit : units_) {
    const Index values = unit.shape.NumValues();
    loss_->ApplyW(unit.loss, u.subspan(at, values), Wu.subspan(at, values));
    Scale(unit.scale, Wu.subspan(at, values));
    at += values;
  }
}

void DeviceSplatLinearization::ApplyH(ConstView v, View Hv) {
  B().Fill(0, Hv);
  for (Unit& unit : units_) {
    const Index values = unit.shape.NumValues();
    const View d_image = image_work_.view().subspan(0, values), weighted = weighted_work_.view().subspan(0, values);
    unit.view.ApplyJ(model_, v.data(), d_image.data(), *workspace_);
    loss_->ApplyW(unit.loss, d_image, weighted);
    Scale(unit.scale, weighted);
    unit.view.AddJT(model_, unit.image.data(), weighted.data(), Hv.data(), *workspace_);
  }
}

void DeviceSplatLinearization::Gradient(View g) { B().Copy(gradient_, g); }

void DeviceSplatLinearization::EnsureGram() {
  if (!gram_blocks_.empty()) return;
  gram_blocks_.Resize(PackedValues(splat::kGeometry) * model_.count);
  gram_sh_.Resize(gradient_.size() - splat::kSh * model_.count);
  if (options_.sh_blocks) gram_sh_blocks_.Resize(PackedValues(ShCoefficients(model_.sh_degree)) * model_.count);
  for (Unit& unit : units_) {
    const View omega = weighted_work_.view().subspan(0, unit.shape.NumValues());
    B().Axpby(unit.scale, unit.loss.diagonal, 0.0, omega);
    unit.view.AddGram(model_, unit.image.data(), omega.data(), gram_blocks_.data(), gram_sh_.data(), *workspace_,
                      options_.sh_blocks ? gram_sh_blocks_.data() : nullptr);
  }
}

void DeviceSplatLinearization::DiagJTJ(View d) {
  EnsureGram();
  const Index n = model_.count;
  for (int a = 0; a < splat::kGeometry; ++a) {
    B().Copy(gram_blocks_.view().subspan(PackedLower(a, a) * n, n), d.subspan(a * n, n));
  }
  B().Copy(gram_sh_, d.subspan(splat::kSh * n, gram_sh_.size()));
}

std::vector<BlockGroup> DeviceSplatLinearization::block_groups() const {
  return SplatBlockGroups(model_.count, model_.sh_degree, options_.sh_blocks);
}

void DeviceSplatLinearization::BlockGram(BlockDiagonal<B>& blocks) {
  EnsureGram();
  B().Copy(gram_blocks_, blocks.values(0));
  B().Copy(options_.sh_blocks ? gram_sh_blocks_ : gram_sh_, blocks.values(1));
  // Nobody asks again, as a rule.
  gram_blocks_ = {}, gram_sh_ = {}, gram_sh_blocks_ = {};
}

}  // namespace vesta::gs
