// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/limit_gaussians.h"

#include <fmt/format.h>

#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/memory/memory_plan.h"

namespace vesta::gs {

void LimitGaussians(TrainingSession& session, const StageRunners& stages, const SplatModel& model) {
  const TrainOptions& options = session.options();
  if (options.memory.budget_gib == 0 && !stages.device_memory) return;
  const MemoryScene counts = session.memory().Count(ToKernelModel(model), 8, false);
  const StageMemory memory = MemoryToPlanBy(stages, options.memory);
  const Index fit = PlanGaussians(counts, options, memory);
  if (stages.device_memory) {
    session.memory().SetSpareDeviceBytes(memory.bytes - memory.adam_bytes(counts.Scaled(fit), options));
  }
  const bool grows = options.density.enabled && options.adam.runs();
  if (options.memory.budget_gib == 0 && grows && fit < options.density.max_gaussians) {
    session.Note(fmt::format("at most {} Gaussians: the GPU has no room for more", fit));
  }
  session.AdaptOptions().density.max_gaussians = fit;
}

}  // namespace vesta::gs
