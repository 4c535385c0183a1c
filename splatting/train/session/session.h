// SPDX-License-Identifier: Apache-2.0
// State shared by the stages of a training: views, clock, history, processes, early end, time budget, interim output,
// memory and notes.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/device_memory.h"
#include "splatting/distributed/process_group.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/memory/stage_bytes.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/history.h"
#include "splatting/train/session/interim_output.h"
#include "splatting/train/session/notes.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/training_cameras.h"
#include "splatting/train/session/training_clock.h"
#include "splatting/train/settings/training_plan.h"

namespace vesta::gs {

// The memory available to the stages now, on the GPU or the host. held_mib: memory in use by the process.
StageMemory MemoryForStages(const StageRunners& stages, const MemoryOptions& options, double held_mib);

// Sizes of models and views for memory planning, of rollback snapshots on the GPU, and of the largest model so far.
class TrainingMemory {
 public:
  // cameras must outlive this object.
  explicit TrainingMemory(const TrainingCameras& cameras) : cameras_(cameras) {}

  // Sizes of this model in the training views. most, with_entries: see CountMemory (memory/stage_bytes.h).
  MemoryScene Count(const splat::Model<float>& model, int most, bool with_entries) const;

  // spare_device_bytes: free GPU memory that the plan of the Adam stage does not use. device_snapshot_bytes: the
  // largest rollback snapshot on the GPU (train/adam_stage/rollback_point.h); 0: none.
  double spare_device_bytes() const { return spare_device_bytes_; }
  void SetSpareDeviceBytes(double bytes) { spare_device_bytes_ = bytes; }
  double device_snapshot_bytes() const { return device_snapshot_bytes_; }
  void NoteDeviceSnapshot(double bytes) { device_snapshot_bytes_ = std::max(device_snapshot_bytes_, bytes); }

  // NoteModel is called before each pruning round, and at the end of the training.
  const splat::ModelLayout& largest_model() const { return largest_model_; }
  void NoteModel(const splat::ModelLayout& layout) {
    if (layout.Size() > largest_model_.Size()) largest_model_ = layout;
  }

 private:
  const TrainingCameras& cameras_;
  double spare_device_bytes_ = 0, device_snapshot_bytes_ = 0;
  splat::ModelLayout largest_model_;
};

class TrainingSession {
 public:
  // seconds_before: since the start of the process. Collective. Throws Error if callbacks.resume belongs to another
  // scene.
  TrainingSession(const Scene& scene, const TrainOptions& options, double seconds_before,
                  const TrainCallbacks& callbacks);
  TrainingSession(const TrainingSession&) = delete;
  TrainingSession& operator=(const TrainingSession&) = delete;

  const TrainOptions& options() const { return options_; }
  const ResolvedPlan& plan() const { return plan_; }
  // Write access for decisions between the stages (train/trainer.cpp, train/lm_stage/lm_stage.cpp). Stages only read
  // the plan.
  ResolvedPlan& Decide() { return plan_; }
  // Schedule of the Adam stage.
  const TrainingSchedule& schedule() const { return schedule_; }

  TrainingCameras& cameras() { return cameras_; }
  const TrainingCameras& cameras() const { return cameras_; }
  // Has the current cameras and exposures of the training views.
  const Scene& scene() const { return cameras_.scene(); }
  const std::vector<const View*>& training_views() const { return cameras_.views(); }
  // Adam iterations per pass over the training views.
  double IterationsPerEpoch() const { return static_cast<double>(training_views().size()) / options_.adam.batch_size; }

  const TrainingClock& clock() const { return clock_; }
  double Seconds() const { return clock_.Seconds(); }
  // Since the training started or resumed.
  double EvalSeconds() const { return clock_.Paused() - saved_.eval_seconds(); }

  const ProcessGroup& processes() const { return processes_; }
  RecordedHistory& history() { return history_; }
  const RecordedHistory& history() const { return history_; }
  EarlyEnd& early_end() { return early_end_; }
  const EarlyEnd& early_end() const { return early_end_; }
  const TimeBudget& time() const { return time_; }
  TrainingMemory& memory() { return memory_; }
  const TrainingMemory& memory() const { return memory_; }
  // The saved state to resume from, if any.
  SavedStage& saved() { return saved_; }
  const SavedStage& saved() const { return saved_; }
  InterimOutput& interim() { return interim_; }

  void Report(const TrainProgress& progress) const {
    if (callbacks_.progress) callbacks_.progress(progress);
  }
  void Predict(const Prediction& prediction) const {
    if (callbacks_.predicted) callbacks_.predicted(prediction);
  }
  // `format` is one of notes.h.
  template <class... Args>
  void Note(fmt::format_string<Args...> format, Args&&... args) {
    notes_.Add(fmt::format(format, std::forward<Args>(args)...));
  }
  std::vector<std::string> TakeNotes() { return notes_.Take(); }

 private:
  void Resume(const Checkpoint& checkpoint);

  const TrainOptions options_;
  ResolvedPlan plan_{options_};
  TrainingSchedule schedule_{options_};
  const TrainCallbacks& callbacks_;
  TrainingCameras cameras_;
  std::uint64_t fingerprint_;  // of the scene with its given cameras
  ProcessGroup processes_;
  SavedStage saved_;
  TrainingClock clock_;
  TrainingNotes notes_;
  RecordedHistory history_;
  EarlyEnd early_end_;
  TimeBudget time_;
  TrainingMemory memory_;
  InterimOutput interim_;
};

// The unit of length of each Gaussian, from the training views (LengthUnits); without a view, the scene's extent.
std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model);

// Evaluates a model in the memory of backend B, or on the host if a GPU has too little memory. copies: device copies of
// the training photographs, if any. model(): the model in the memory of B; may throw OutOfDeviceMemory. on_host(): a
// copy on the host.
template <class B>
Evaluation EvaluateOrDownload(TrainingSession& session, std::span<const TargetView<B>> copies,
                              const std::function<splat::Model<float>()>& model,
                              typename SplatBackend<B>::Workspace& workspace, const ModelOnHost& on_host) {
  try {
    return Evaluate<B>(session.scene(), session.options().background, copies, model(), workspace,
                       session.history().measured_views());
  } catch (const OutOfDeviceMemory&) {
    return session.history().Evaluate(on_host());
  }
}

}  // namespace vesta::gs
