// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/training_memory.h"

#include "kernels/core/profile.h"

namespace vesta::gs {

StageMemory MemoryToPlanBy(const StageRunners& stages, const MemoryOptions& options, double held_mib) {
  return stages.device_memory ? DeviceMemory(options, stages.device_memory().free_bytes)
                              : HostMemory(options, held_mib);
}

MemoryScene TrainingMemory::Count(const splat::Model<float>& model, int most, bool with_entries) const {
  const ScopedPhase phase("memory plan");
  return CountMemory(model, cameras_.views(), NearPlane(cameras_.scene()), most, with_entries);
}

}  // namespace vesta::gs
