// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/session.h"

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "problems/gaussian_splatting/model/length_units.h"

namespace vesta::gs {

TrainingSession::TrainingSession(const Scene& scene, const TrainOptions& options, double seconds_before,
                                 const TrainCallbacks& callbacks)
    : options_(options),
      callbacks_(callbacks),
      cameras_(scene, options.cameras),
      fingerprint_(FingerprintOf(scene)),
      processes_(callbacks.ranks),
      saved_(callbacks.resume),
      clock_(seconds_before + saved_.seconds(), saved_.eval_seconds()),
      history_(cameras_, options_, callbacks_, clock_),
      early_end_(options_, callbacks_, processes_, clock_, history_),
      time_(options_, processes_, clock_),
      memory_(cameras_),
      interim_({.callbacks = callbacks_,
                .fingerprint = fingerprint_,
                .saved = saved_,
                .cameras = cameras_,
                .history = history_,
                .early_end = early_end_,
                .clock = clock_,
                .notes = notes_}) {
  if (callbacks.resume) Resume(*callbacks.resume);
}

void TrainingSession::Resume(const Checkpoint& checkpoint) {
  if (checkpoint.run.scene != fingerprint_) {
    Fail(kBadArgument, "{}: belongs to other photographs or cameras; use the scene that it was trained on",
         checkpoint.path);
  }
  history_.Restore(checkpoint.run.history);
  notes_.Restore(checkpoint.run.notes);
  if (!cameras_.Restore(checkpoint.run.cameras)) saved_.Refuse();
}

std::vector<float> TrainingUnits(const TrainingSession& session, const SplatModel& model) {
  const Scene& scene = session.scene();
  return LengthUnits(model, session.training_views(), NearPlane(scene), scene.extent);
}

StageMemory MemoryForStages(const StageRunners& stages, const MemoryOptions& options, double held_mib) {
  return stages.device_memory ? DeviceMemory(options, stages.device_memory().free_bytes)
                              : HostMemory(options, held_mib);
}

MemoryScene TrainingMemory::Count(const splat::Model<float>& model, int most, bool with_entries) const {
  const ScopedPhase phase("memory plan");
  return CountMemory(model, cameras_.views(), NearPlane(cameras_.scene()), most, with_entries);
}

}  // namespace vesta::gs
