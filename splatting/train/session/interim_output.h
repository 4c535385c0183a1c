// SPDX-License-Identifier: Apache-2.0
// Output during a training: checkpoints, snapshots, and the requests of a viewer.
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
  // References to the session state that this class saves and consults. All must outlive this object.
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

  // True if checkpoints may be written.
  bool Saves() const;
  // True if this process has written a checkpoint.
  bool has_saved() const { return has_saved_; }
  // Call after each iteration. Saves the state if an interval has passed, if the viewer requests it, or if a training
  // with intervals stops. state: writes it. An older checkpoint stays until the new one is complete.
  void SaveWhereDue(Stage stage, int iteration, const WriteState& state);
  // Call at the end of each iteration except the last. Serves the viewer's requests, and waits while it pauses the
  // training.
  void ServeViewer(Stage stage, int iteration, const ModelOnHost& on_host, const WriteState& state);
  // Writes a snapshot of the model if one is due.
  void SnapshotWhereDue(Stage stage, int iteration, const ModelOnHost& on_host);

 private:
  // seconds: of the training.
  void Save(Stage stage, int iteration, double seconds, const WriteState& state);
  // Runs `write`. Turns an Error into a note and returns it; else returns an empty string.
  std::string NoteError(const char* what, const std::function<void()>& write);

  Parts parts_;
  const TrainCallbacks& callbacks_;
  TrainingClock& clock_;
  // Start at the beginning of the training, or where it resumed.
  IntervalTimer checkpoint_timer_, snapshot_timer_;
  bool has_saved_ = false;
};

}  // namespace vesta::gs
