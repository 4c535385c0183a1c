// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/memory_limits.h"

#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/memory/stage_bytes.h"

namespace vesta::gs {

void LimitGaussians(TrainingSession& session, const StageRunners& stages, const SplatModel& model) {
  const TrainOptions& options = session.options();
  if (options.memory.budget_gib == 0 && !stages.device_memory) return;
  const MemoryScene counts = session.memory().Count(ToKernelModel(model), 8, false);
  const StageMemory memory = MemoryToPlanBy(stages, options.memory, session.plan().held_mib);
  const Index fit = PlanGaussians(counts, options, memory);
  if (stages.device_memory) {
    session.memory().SetSpareDeviceBytes(memory.bytes - memory.adam_bytes(counts.Scaled(fit), options));
  }
  const bool grows = options.density.enabled && options.adam.runs();
  if (options.memory.budget_gib == 0 && grows && fit < options.density.max_gaussians) {
    session.Note(notes::kFewerGaussiansFit, fit);
  }
  session.Decide().max_gaussians = fit;
}

MemoryReport ReportOfMemory(TrainingSession& session, const StageRunners& stages, const SplatModel& model,
                            const LmOutcome& lm) {
  session.memory().NoteModel(model);
  const TrainOptions& options = session.options();
  const ResolvedPlan& plan = session.plan();
  const MemoryScene largest = lm.counts.Of(session.memory().largest_model());
  MemoryReport report;
  report.jacobian = plan.lm.jacobian;
  report.batches = static_cast<int>(lm.batches);
  if (!stages.device_memory) {
    report.predicted_mib = plan.held_mib + PredictedMib(largest, options, plan.lm_memory.bytes);
    return report;
  }
  report.predicted_mib = plan.held_mib + PredictedMibBesideDevice(largest, options);
  report.device_predicted_mib =
      PredictedDeviceMib(largest, options, plan.lm_memory.bytes, session.memory().kept_on_device());
  report.device_peak_mib = stages.device_memory().peak_bytes / kMib;
  return report;
}

}  // namespace vesta::gs
