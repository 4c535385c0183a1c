// SPDX-License-Identifier: Apache-2.0
// Output during a training: checkpoints, snapshots of the model, and answers to a viewer.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/history.h"
#include "splatting/train/session/notes.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/training_cameras.h"
#include "splatting/train/session/training_clock.h"

namespace vesta::gs {

// Writes the state of a stage.
using WriteState = std::function<void(ArchiveWriter&)>;

class InterimOutput {
 public:
  // Parts of the session that are saved or read. All must outlive this object.
  struct Parts {
    const TrainCallbacks& callbacks;
    std::uint64_t fingerprint;  // of the scene with its given cameras
    const SavedStage& saved;
    const TrainingCameras& cameras;
    const RecordedHistory& history;
    const EarlyEnd& early_end;
    TrainingClock& clock;
    TrainingNotes& notes;
  };
  explicit InterimOutput(const Parts& parts);

  // Whether checkpoints may be written: there is a path, and an interval or a viewer that can request them.
  bool Saves() const;
  // Whether this process has written a checkpoint.
  bool has_saved() const { return has_saved_; }
  // Call after each iteration. Writes a checkpoint if the interval has passed or the viewer requests one. With an
  // interval, also writes one at an early stop. state: writes the state of the stage. A failure becomes a note.
  void SaveWhereDue(Stage stage, int iteration, const WriteState& state);
  // Call at the end of each iteration except the last. Passes the model to the viewer on request. Returns only after
  // the viewer's pauses, which count neither as training nor as evaluation.
  void ServeViewer(Stage stage, int iteration, const ModelOnHost& on_host, const WriteState& state);
  // Calls TrainCallbacks::snapshot if its interval has passed. A failure becomes a note.
  void SnapshotWhereDue(Stage stage, int iteration, const ModelOnHost& on_host);

 private:
  // seconds: of the training.
  void Save(Stage stage, int iteration, double seconds, const WriteState& state);
  // If `write` throws Error, adds and returns the note "WHAT: MESSAGE"; else returns an empty string.
  std::string NoteError(const char* what, const std::function<void()>& write);

  Parts parts_;
  const TrainCallbacks& callbacks_;
  TrainingClock& clock_;
  // The timers start when the training starts or resumes.
  IntervalTimer checkpoint_timer_, snapshot_timer_;
  bool has_saved_ = false;
};

}  // namespace vesta::gs
