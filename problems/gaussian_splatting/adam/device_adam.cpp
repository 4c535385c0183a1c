#include "problems/gaussian_splatting/adam/device_adam.h"

#include <utility>

#include "problems/gaussian_splatting/adam/device_updates.h"

namespace vesta::gs {
namespace {

HostSpan<const float> ViewOf(const std::vector<float>& v) { return {v.data(), static_cast<Index>(v.size())}; }

std::vector<float> ToHost(const DeviceBuffer<float>& buffer) {
  std::vector<float> values(static_cast<std::size_t>(buffer.size()));
  buffer.CopyTo({values.data(), buffer.size()});
  return values;
}

}  // namespace

void DeviceAdam::Upload(const SplatModel& model) {
  if (adam_.moments().first.empty()) adam_.Start(model);
  const AdamMoments moments = adam_.TakeMoments();
  first_.CopyFrom(ViewOf(moments.first));
  second_.CopyFrom(ViewOf(moments.second));
  bases_.CopyFrom(ViewOf(moments.bases.Flat()));
}

Adam DeviceAdam::Download(Index count) const {
  Adam adam = adam_;
  adam.SetMoments(count, {ToHost(first_), ToHost(second_), BlockBases(bases_.empty() ? 0 : count, ToHost(bases_))});
  return adam;
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

void DeviceAdam::Rearrange(Index count, const DeviceBuffer<std::uint32_t>& source,
                           const DeviceBuffer<std::uint8_t>& kept) {
  // The bases, being the most, first: if they fit, so do the moments of a model that does not grow.
  if (!bases_.empty()) {
    DeviceBuffer<float> bases;
    bases.ResizeForOverwrite(BlockArraySize(source.size()));
    device_updates::GatherBases({source.size(), source.data(), kept.data(), bases_.data(), bases.data()});
    bases_ = std::move(bases);
  }
  for (DeviceBuffer<float>* moments : {&first_, &second_}) {
    const Index attributes = moments->size() / count;
    DeviceBuffer<float> gathered;
    gathered.ResizeForOverwrite(attributes * source.size());
    device_updates::GatherRows(
        {attributes, count, source.size(), source.data(), kept.data(), moments->data(), gathered.data()});
    *moments = std::move(gathered);
  }
}

void DeviceAdam::Reset(Index count, int attribute) {
  const std::size_t bytes = static_cast<std::size_t>(count) * sizeof(float);
  device::SetZero(first_.data() + attribute * count, bytes);
  if (attribute >= adam_.first_diagonal()) device::SetZero(second_.data() + attribute * count, bytes);
}

}  // namespace vesta::gs
