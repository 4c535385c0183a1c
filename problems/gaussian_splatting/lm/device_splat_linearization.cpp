#include "problems/gaussian_splatting/lm/device_splat_linearization.h"

#include <algorithm>

#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/device_view_agreement.h"
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
      views_(views),
      scale_(scale),
      turn_(turn),
      units_(views.size()),
      loss_(std::move(loss)),
      workspace_(std::move(workspace)) {
  model_ = {x.data(), options.count, options.sh_degree, options.sh_degree};
  Index largest = 0;
  for (const DeviceBatchView& view : views) {
    const Index values = view.target->shape().NumValues();
    num_residuals_ += values;
    largest = std::max(largest, values);
  }
  image_work_.ResizeForOverwrite(largest);
  weighted_work_.ResizeForOverwrite(largest);
  MakeUnits();
}

void DeviceSplatLinearization::MakeUnits() {
  gradient_.Resize(num_parameters());
  const bool steers = has_own_descent();
  DeviceBuffer<float> of_view;
  if (steers) of_view.Resize(num_parameters()), descent_.Resize(num_parameters());
  for (std::size_t i = 0; i < views_.size(); ++i) {
    Unit& unit = units_[i];
    unit.target = views_[i].target;
    unit.scale = scale_;
    unit.shape = unit.target->shape();
    const Index values = unit.shape.NumValues();
    const View image_gradient = image_work_.view().subspan(0, values);
    unit.view.Build(model_, unit.target->pinhole, options_.background.data(), *workspace_);
    unit.image.ResizeForOverwrite(values);
    unit.view.Render(unit.image.data());
    loss_->Linearize(unit.image, unit.target->truth, unit.shape, image_gradient, unit.loss);
    if (options_.sample_gradient) Prepare(views_[i], unit);
    Scale(unit.scale, image_gradient);
    unit.view.AddJT(model_, unit.image.data(), image_gradient.data(), (steers ? of_view : gradient_).data(),
                    *workspace_);
    if (steers) device_view_agreement::Add({of_view.data(), gradient_.data(), descent_.data()}, num_parameters());
    // After the gradient, which is thereby exact.
    if (!options_.sample_gradient) Prepare(views_[i], unit);
  }
  if (steers) {
    device_view_agreement::Descend({static_cast<float>(options_.view_agreement), static_cast<float>(views_.size()),
                                    gradient_.data(), descent_.data()},
                                   num_parameters());
  }
}

void DeviceSplatLinearization::Prepare(const DeviceBatchView& from, Unit& unit) const {
  if (options_.residual_sampling < 1) {
    const PixelSample sample = SamplePixels(options_.sampling_unit, unit.view.num_tiles(), options_.residual_sampling,
                                            options_.seed, turn_, from.index);
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

void DeviceSplatLinearization::Gradient(View g) {
  if (gradient_.empty()) MakeUnits();
  B().Copy(gradient_, g);
  gradient_ = {};  // nobody asks again, as a rule
}

void DeviceSplatLinearization::Descent(View d) {
  if (!has_own_descent()) return Linearization::Descent(d);
  if (descent_.empty()) MakeUnits();
  B().Copy(descent_, d);
  descent_ = {};
}

void DeviceSplatLinearization::AddGram(float* blocks, float* sh_diagonal, float* sh_blocks) {
  for (Unit& unit : units_) {
    const View omega = weighted_work_.view().subspan(0, unit.shape.NumValues());
    B().Axpby(unit.scale, unit.loss.diagonal, 0.0, omega);
    unit.view.AddGram(model_, unit.image.data(), omega.data(), blocks, sh_diagonal, *workspace_, sh_blocks);
  }
  // The largest of the workspace, and idle until the next x.
  workspace_->pair_grams = {}, workspace_->splat_grams = {};
}

void DeviceSplatLinearization::DiagJTJ(View d) {
  const Index n = model_.count;
  if (gram_blocks_.empty()) {
    gram_blocks_.Resize(PackedValues(splat::kGeometry) * n);
    gram_sh_.Resize(num_parameters() - splat::kSh * n);
    if (options_.sh_blocks) gram_sh_blocks_.Resize(PackedValues(ShCoefficients(model_.sh_degree)) * n);
    AddGram(gram_blocks_.data(), gram_sh_.data(), options_.sh_blocks ? gram_sh_blocks_.data() : nullptr);
  }
  for (int a = 0; a < splat::kGeometry; ++a) {
    B().Copy(gram_blocks_.view().subspan(PackedLower(a, a) * n, n), d.subspan(a * n, n));
  }
  B().Copy(gram_sh_, d.subspan(splat::kSh * n, gram_sh_.size()));
}

std::vector<BlockGroup> DeviceSplatLinearization::block_groups() const {
  return SplatBlockGroups(model_.count, model_.sh_degree, options_.sh_blocks);
}

void DeviceSplatLinearization::BlockGram(BlockDiagonal<B>& blocks) {
  if (gram_blocks_.empty()) {
    DeviceBuffer<float> diagonal(options_.sh_blocks ? num_parameters() - splat::kSh * model_.count : 0);
    float* const sh = blocks.values(1).data();
    AddGram(blocks.values(0).data(), options_.sh_blocks ? diagonal.data() : sh, options_.sh_blocks ? sh : nullptr);
    return;
  }
  B().Copy(gram_blocks_, blocks.values(0));
  B().Copy(options_.sh_blocks ? gram_sh_blocks_ : gram_sh_, blocks.values(1));
  gram_blocks_ = {}, gram_sh_ = {}, gram_sh_blocks_ = {};  // nobody asks again unless a step is refused
}

}  // namespace vesta::gs
