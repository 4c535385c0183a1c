// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/interim_output.h"

#include <fmt/format.h>

#include "kernels/core/profile.h"

namespace vesta::gs {

InterimOutput::InterimOutput(const Parts& parts)
    : parts_(parts),
      callbacks_(parts.callbacks),
      clock_(parts.clock),
      checkpoint_timer_(parts.saved.seconds()),
      snapshot_timer_(parts.saved.seconds()) {}

bool InterimOutput::Saves() const {
  const CheckpointOptions& options = callbacks_.checkpoint;
  return !options.path.empty() && (!options.every.never() || callbacks_.watch.wants_checkpoint);
}

std::string InterimOutput::NoteError(const char* what, const std::function<void()>& write) {
  try {
    write();
  } catch (const Error& error) {
    // A failed write must not end the training.
    std::string line = fmt::format("{}: {}", what, error.what());
    parts_.notes.Add(line);
    return line;
  }
  return "";
}

void InterimOutput::SaveWhereDue(Stage stage, int iteration, const WriteState& state) {
  if (!Saves()) return;
  const CheckpointOptions& options = callbacks_.checkpoint;
  const bool is_time = checkpoint_timer_.IsDue(options.every, stage, iteration, clock_.Seconds());
  const bool is_asked = callbacks_.watch.wants_checkpoint && callbacks_.watch.wants_checkpoint();
  const bool is_due = is_time || is_asked || (parts_.early_end.stopped() && !options.every.never());
  if (is_due) Save(stage, iteration, clock_.Seconds(), state);
}

void InterimOutput::Save(Stage stage, int iteration, double seconds, const WriteState& state) {
  const ScopedPhase phase("checkpoint");
  const CheckpointOptions& options = callbacks_.checkpoint;
  RunState run{.origin = options.origin,
               .stage = stage,
               .iteration = iteration,
               .scene = parts_.fingerprint,
               .seconds = seconds,
               .eval_seconds = clock_.Paused(),
               .history = parts_.history.rows(),
               .notes = parts_.notes.lines(),
               .cameras = parts_.cameras.found()};
  const std::string error = NoteError("no checkpoint", [&] { WriteCheckpoint(options.path, run, state); });
  has_saved_ = has_saved_ || error.empty();
  if (callbacks_.watch.saved) callbacks_.watch.saved(iteration, error);
}

void InterimOutput::ServeViewer(Stage stage, int iteration, const ModelOnHost& on_host, const WriteState& state) {
  const ScopedPhase phase("viewer");
  const TrainWatch& watch = callbacks_.watch;
  bool is_shown = false;  // the model does not change during a pause
  const auto show_where_wanted = [&] {
    if (is_shown || !watch.wants_model || !watch.wants_model()) return;
    watch.show(on_host(), parts_.cameras.found());
    is_shown = true;
  };
  show_where_wanted();
  if (!watch.waits) return;
  // Work during a pause is not training time.
  const double seconds = clock_.Seconds();
  const TrainingClock::ExcludedTime absence(clock_);
  while (watch.waits()) {
    if (Saves() && watch.wants_checkpoint && watch.wants_checkpoint()) Save(stage, iteration, seconds, state);
    show_where_wanted();
  }
}

void InterimOutput::SnapshotWhereDue(Stage stage, int iteration, const ModelOnHost& on_host) {
  if (!callbacks_.snapshot) return;
  if (!snapshot_timer_.IsDue(callbacks_.snapshot_every, stage, iteration, clock_.Seconds())) return;
  const ScopedPhase phase("snapshot");
  NoteError("no snapshot", [&] { callbacks_.snapshot(stage, iteration, on_host()); });
}

}  // namespace vesta::gs
