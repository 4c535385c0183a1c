// Adam in the memory of a GPU: moments and bases are there, and follow the model there.
#pragma once

#include <cstdint>

#include "kernels/core/device_buffer.h"
#include "problems/gaussian_splatting/adam/adam.h"

namespace vesta::gs {

class DeviceAdam {
 public:
  // steps: that were done before. Rates, and at first moments and bases, are those of `adam`, which must outlive this.
  DeviceAdam(Adam& adam, int steps) : adam_(adam), steps_(steps) {}

  // To the GPU, the host's being freed. model: to start from where no step has been done.
  void Upload(const SplatModel& model);
  // The host's, with moments and bases as they are now, of so many Gaussians.
  Adam Download(Index count) const;
  // As Adam::SetUnits; to be set before the first step.
  void SetUnits(DeviceBuffer<float> units) { units_ = std::move(units); }
  // As Adam::Step on the attributes [0, attributes) of `count` Gaussians, in the memory of the GPU. Does not wait.
  void Step(Index count, float* parameters, float* gradient, int attributes, double factor);
  // As Adam::Rearrange: Gaussian i of the new model is source[i] of the `count` there were, with its moments where
  // kept[i]. Throws OutOfDeviceMemory.
  void Rearrange(Index count, const DeviceBuffer<std::uint32_t>& source, const DeviceBuffer<std::uint8_t>& kept);
  // As Adam::Reset, of `count` Gaussians.
  void Reset(Index count, int attribute);

 private:
  Adam& adam_;
  int steps_;
  DeviceBuffer<float> first_, second_, bases_, units_;
};

}  // namespace vesta::gs
