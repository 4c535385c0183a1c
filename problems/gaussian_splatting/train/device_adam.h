// Adam in the memory of a GPU: moments and bases are there between changes of the model's size, which happen on the
// host.
#pragma once

#include "kernels/core/device_buffer.h"
#include "problems/gaussian_splatting/train/adam.h"

namespace vesta::gs {

class DeviceAdam {
 public:
  // steps: that were done before. Rates and units, and moments and bases while on the host, are those of `adam`, which
  // must outlive this.
  DeviceAdam(Adam& adam, int steps) : adam_(adam), steps_(steps) {}

  // To the GPU, the host's being freed; units are copied. model: to start from where no step has been done.
  void Upload(const SplatModel& model);
  // Back to the host.
  void Download();
  // As Adam::Step on the attributes [0, attributes) of `count` Gaussians, in the memory of the GPU. Does not wait.
  void Step(Index count, float* parameters, float* gradient, int attributes, double factor);

 private:
  Adam& adam_;
  int steps_;
  DeviceBuffer<float> first_, second_, bases_, units_;
};

}  // namespace vesta::gs
