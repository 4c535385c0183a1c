// SPDX-License-Identifier: Apache-2.0
// Checkpoints: files with the state of a training. A resumed training ends with the same bits as a training without an
// interruption.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/check.h"
#include "kernels/core/device_memory.h"
#include "kernels/ranks/communicator.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/train/session/train_result.h"

namespace vesta::gs {

// The part that is common to both stages, Adam and LM.
struct RunState {
  // Text for the caller, such as the folder of the photographs and the options. Stored unchanged.
  std::string origin = {};
  Stage stage = Stage::kAdam;
  int iteration = 0;                     // done in the stage
  std::uint64_t scene = 0;               // FingerprintOf the scene
  double seconds = 0, eval_seconds = 0;  // of the training without evaluations; of evaluations
  std::vector<HistoryRow> history = {};
  std::vector<std::string> notes = {};
  std::vector<ViewUnknowns> cameras = {};  // of the training views if cameras are refined; else empty

  template <class Archive>
  void Visit(Archive& archive) {
    archive(origin, stage, iteration, scene, seconds, eval_seconds, history, notes, cameras);
  }
};

struct Checkpoint {
  std::string path;  // for messages
  RunState run;
  std::string stage_state;  // of the current stage

  int iteration() const { return run.iteration; }
};

// A hash of the names, sizes, cameras, poses and roles of all views, not of photographs and points.
std::uint64_t FingerprintOf(const Scene& scene);

// stage_state: writes the state of the stage. An older file at `path` stays until the new one is complete
// (kernels/core/files.h). Throws Error, with the path, if the file cannot be written.
void WriteCheckpoint(const std::string& path, RunState& run, const std::function<void(ArchiveWriter&)>& stage_state);

// Whether the file starts like a checkpoint; false if it cannot be read.
bool IsCheckpoint(const std::string& path);

// Throws Error, with the path, if the file is missing, not a checkpoint, of another version, truncated or damaged.
Checkpoint ReadCheckpoint(const std::string& path);

// The saved state to resume from, if any. Its stage reads it once (Take).
class SavedStage {
 public:
  // null: a new training. Must outlive this object.
  explicit SavedStage(const Checkpoint* checkpoint) : checkpoint_(checkpoint) {
    if (checkpoint) state_ = checkpoint->stage_state;  // refers to the checkpoint's memory, as the state may be large
  }

  // The stage to resume, and its finished iterations.
  Stage first_stage() const { return checkpoint_ ? checkpoint_->run.stage : Stage::kAdam; }
  int first_iteration() const { return checkpoint_ ? checkpoint_->iteration() : 0; }
  const std::string& path() const { return checkpoint_->path; }  // requires a checkpoint
  // Time until the state was saved, in seconds: seconds() without evaluations, eval_seconds() of evaluations alone.
  // Both are 0 without a checkpoint.
  double seconds() const { return checkpoint_ ? checkpoint_->run.seconds : 0; }
  double eval_seconds() const { return checkpoint_ ? checkpoint_->run.eval_seconds : 0; }

  // Empty without a checkpoint, or after Take().
  const std::optional<std::string_view>& state() const { return state_; }
  // The state if it belongs to stage `of` and was not taken before.
  std::optional<std::string_view> Take(Stage of) {
    return of == first_stage() ? std::exchange(state_, std::nullopt) : std::nullopt;
  }
  // Take() then returns this state again.
  void GiveBack(std::optional<std::string_view> state) { state_ = state; }

  // Throws Error that the saved state is invalid, with the checkpoint's path and, if given, the reason.
  [[noreturn]] void Refuse(const std::string& why = "") const {
    Fail(kBadFile,
         "{}: the saved state does not fit this training{}; resume from another checkpoint, or start a new training",
         checkpoint_->path, why.empty() ? "" : fmt::format(" ({})", why));
  }
  // Returns read(), which reads the saved state. If read() throws Error, calls Refuse() with that message. Exceptions
  // for lack of device memory or another process's failure pass through.
  template <class Read>
  auto Validate(const Read& read) const {
    try {
      return read();
    } catch (const OutOfDeviceMemory&) {
      throw;
    } catch (const OtherRankFailed&) {
      throw;
    } catch (const Error& error) {
      Refuse(error.what());
    }
  }

 private:
  const Checkpoint* checkpoint_;
  std::optional<std::string_view> state_;
};

}  // namespace vesta::gs
