// SPDX-License-Identifier: Apache-2.0
// What leaves a training before its end: checkpoints, snapshots, and what its watch asks for.
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
  // Of the session: what is written, and what that goes by. All must outlive this.
  struct Parts {
    const TrainCallbacks& callbacks;
    std::uint64_t fingerprint;  // of the scene as it was given
    const SavedStage& saved;
    const TrainingCameras& cameras;
    const RecordedHistory& history;
    const EarlyEnd& early_end;
    TrainingClock& clock;
    TrainingNotes& notes;
  };
  explicit InterimOutput(const Parts& parts);

  // Whether the state may be saved after an iteration.
  bool Saves() const;
  // Whether this process has.
  bool has_saved() const { return has_saved_; }
  // After each iteration: saves the state of the stage where that is due, or is asked for, or where a training that
  // saves at intervals stops; state: writes it. An older checkpoint stays until the new one is complete, and where that
  // cannot be written.
  void SaveWhereDue(Stage stage, int iteration, const WriteState& state);
  // At the end of an iteration that others follow: does what the watch asks for, and waits as long as it does.
  void AttendToWatch(Stage stage, int iteration, const ModelOnHost& on_host, const WriteState& state);
  // Hands out the model on the way, where that is due.
  void SnapshotWhereDue(Stage stage, int iteration, const ModelOnHost& on_host);

 private:
  // seconds: of the run.
  void Save(Stage stage, int iteration, double seconds, const WriteState& state);
  // Writes what is written on the way; where that fails it says so in a note. Returns that note, else nothing.
  std::string NoteError(const char* what, const std::function<void()>& write);

  Parts parts_;
  const TrainCallbacks& callbacks_;
  TrainingClock& clock_;
  // From where the training begins, or goes on.
  IntervalTimer checkpoint_timer_, snapshot_timer_;
  bool has_saved_ = false;
};

}  // namespace vesta::gs
