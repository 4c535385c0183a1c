// SPDX-License-Identifier: Apache-2.0
// A step of Adam, and its bases, on a GPU.
#pragma once

#include "kernels/core/device_buffer.h"
#include "splatting/adam/adam_steps.h"

namespace vesta::gs {

// All Gaussians share one array (BlockEntry). Rearrange needs memory for a second array. If that is lacking, the Adam
// stage restores an earlier state or ends (RunAdamStage).
template <>
class BlockBases<Device> {
 public:
  BlockBases() = default;
  explicit BlockBases(Index count) { numbers_.CopyFrom(BlockBases<Host>(count).Flat()); }

  bool empty() const { return numbers_.empty(); }
  Index size() const { return numbers_.size(); }
  float* data() { return numbers_.data(); }
  // As on the host. Throws OutOfDeviceMemory if memory runs out.
  void Rearrange(Span<const std::uint32_t, Device> source, Span<const std::uint8_t, Device> kept);
  BlockBases<Host> OnHost(Index count) const;

  template <class Archive>
  void Visit(Archive& archive) {
    archive(numbers_);
  }

 private:
  DeviceBuffer<float> numbers_;
};

template <>
struct AdamSteps<Device> {
  // Asynchronous.
  static void Run(const AdamStepArrays& arrays, BlockBases<Device>& bases);
};

}  // namespace vesta::gs
