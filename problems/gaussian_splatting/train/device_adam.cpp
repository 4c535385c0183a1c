#include "problems/gaussian_splatting/train/device_adam.h"

#include <utility>

#include "problems/gaussian_splatting/train/device_updates.h"

namespace vesta::gs {
namespace {

HostSpan<const float> ViewOf(const std::vector<float>& v) { return {v.data(), static_cast<Index>(v.size())}; }

}  // namespace

void DeviceAdam::Upload(const SplatModel& model) {
  if (adam_.first_moments().empty()) adam_.Start(model);
  units_.CopyFrom(ViewOf(adam_.units()));
  for (auto [buffer, values] :
       {std::pair(&first_, &adam_.first_moments()), {&second_, &adam_.second_moments()}, {&bases_, &adam_.bases()}}) {
    buffer->CopyFrom(ViewOf(*values));
    *values = std::vector<float>();
  }
}

void DeviceAdam::Download() {
  for (auto [buffer, values] :
       {std::pair(&first_, &adam_.first_moments()), {&second_, &adam_.second_moments()}, {&bases_, &adam_.bases()}}) {
    values->resize(static_cast<std::size_t>(buffer->size()));
    buffer->CopyTo({values->data(), buffer->size()});
  }
}

void DeviceAdam::Step(Index count, float* parameters, float* gradient, int attributes, double factor) {
  ++steps_;
  if (!bases_.empty()) {
    BlockAdamArrays blocks = adam_.BlockRates(factor, steps_);
    blocks.count = count;
    blocks.gradient = gradient;
    blocks.parameters = parameters;
    blocks.first = first_.data();
    blocks.second = second_.data();
    blocks.bases = bases_.data();
    blocks.units = units_.data();
    device_updates::StepBlocks(blocks);
    device_updates::TurnBases(blocks, steps_);
  }
  device_updates::AdamArrays arrays{.count = count,
                                    .first_attribute = adam_.first_diagonal(),
                                    .attributes = attributes,
                                    .gradient = gradient,
                                    .parameters = parameters,
                                    .first = first_.data(),
                                    .second = second_.data(),
                                    .units = units_.data(),
                                    .rate = {},
                                    .root_correction2 = Adam::RootCorrection2(steps_)};
  for (int a = 0; a < attributes; ++a) arrays.rate[a] = adam_.StepRate(a, factor, steps_);
  device_updates::StepAdam(arrays);
}

}  // namespace vesta::gs
