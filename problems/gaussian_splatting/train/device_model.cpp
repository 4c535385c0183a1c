#include "problems/gaussian_splatting/train/device_model.h"

#include <utility>

#include "problems/gaussian_splatting/adam/device_updates.h"
#include "problems/gaussian_splatting/density/device_density_steps.h"

namespace vesta::gs {
namespace {

template <class T>
HostSpan<const T> ViewOf(const std::vector<T>& v) {
  return {v.data(), static_cast<Index>(v.size())};
}

}  // namespace

DeviceModel::DeviceModel(SplatModel& model, Adam& adam, int steps, DeviceDensityControl& density,
                         const std::vector<splat::PinholeView>& unit_views, double unit)
    : model_(model), density_(density), adam_(adam, steps), unit_(unit) {
  x_.CopyFrom(ViewOf(model_.data));
  adam_.Upload(model_);
  unit_views_.CopyFrom(ViewOf(unit_views));
  StartAnew();
}

void DeviceModel::Densify(int iteration, const std::function<void()>& before_growth) {
  average_.StartAnew();
  gradient_ = DeviceBuffer<float>();  // zero between steps; its room is needed
  const DensityPlan plan = density_.Decide(x_.data(), model_.count);
  if (plan.count > model_.count) before_growth();
  if (plan.changes) Rearrange(plan, iteration);
  StartAnew();
}

void DeviceModel::Rearrange(const DensityPlan& plan, int iteration) {
  adam_.Rearrange(model_.count, plan.source, plan.kept);
  const Index attributes = model_.num_attributes();
  DeviceBuffer<float> x;
  x.ResizeForOverwrite(attributes * plan.count);
  // Of parameters new Gaussians have copies.
  const std::uint8_t* all = nullptr;
  device_updates::GatherRows({attributes, model_.count, plan.count, plan.source.data(), all, x_.data(), x.data()});
  density_.Renew(plan, iteration, x.data());
  x_ = std::move(x);
  model_.count = plan.count;
}

void DeviceModel::StartAnew() {
  gradient_.Resize(x_.size());
  density_.Forget(model_.count);
  DeviceBuffer<float> units;
  units.ResizeForOverwrite(model_.count);
  device_updates::MeasureUnits(model_.count, x_.data(), unit_views_.data(), unit_views_.size(), unit_, units.data());
  adam_.SetUnits(std::move(units));
}

void DeviceModel::ResetOpacity() {
  average_.StartAnew();
  device_density::LowerLogits(model_.count, x_.data() + splat::kOpacity * model_.count);
  adam_.Reset(model_.count, splat::kOpacity);
}

void DeviceModel::DownloadParameters() {
  const DeviceBuffer<float>& result = Result();
  model_.data.resize(static_cast<std::size_t>(result.size()));
  result.CopyTo({model_.data.data(), result.size()});
}

}  // namespace vesta::gs
