// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/memory_report.h"

#include "splatting/memory/memory_plan.h"
#include "splatting/memory/stage_bytes.h"

namespace vesta::gs {
MemoryReport ReportOfMemory(TrainingSession& session, const StageRunners& stages, const SplatModel& model,
                            const LmOutcome& lm) {
  session.memory().NoteModel(model);
  const TrainOptions& options = session.options();
  const MemoryScene largest = lm.counts.Of(session.memory().largest_model());
  MemoryReport report;
  report.jacobian = lm.plan.lm.jacobian;
  report.batches = static_cast<int>(lm.batches);
  if (!stages.device_memory) {
    report.predicted_mib = PredictedMib(largest, options, lm.plan.bytes);
    return report;
  }
  report.predicted_mib = PredictedMibBesideDevice(largest, options);
  report.device_predicted_mib = PredictedDeviceMib(largest, options, lm.plan.bytes, session.memory().kept_on_device());
  report.device_peak_mib = stages.device_memory().peak_bytes / kMib;
  return report;
}

}  // namespace vesta::gs
