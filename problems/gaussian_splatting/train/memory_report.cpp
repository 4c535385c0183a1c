#include "problems/gaussian_splatting/train/memory_report.h"

#include "problems/gaussian_splatting/memory/memory_plan.h"
#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::gs {
namespace {

constexpr double kMib = 1 << 20;

// Sizes of the largest model that there was. Adam's stage may have held more views than LM's.
MemoryScene LargestScene(TrainingSession& session, const SplatModel& model, const MemoryScene& of_lm) {
  const TrainingMemory& memory = session.memory();
  const bool differ = memory.PlannedViews(Stage::kAdam).size() != memory.PlannedViews(Stage::kLm).size();
  const MemoryScene of_adam = differ ? memory.Count(ToKernelModel(model), Stage::kAdam, 4, false) : of_lm;
  return of_adam.Of(memory.largest_model());
}

}  // namespace

MemoryReport ReportOfMemory(TrainingSession& session, const StageRunners& stages, const SplatModel& model,
                            const LmOutcome& lm) {
  session.memory().NoteModel(model);
  const TrainOptions& options = session.options();
  const MemoryScene largest = LargestScene(session, model, lm.counts);
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
