// SPDX-License-Identifier: Apache-2.0
// Checkpoints: the state of a training in a file, from which a stage resumes bit-identically.
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

// State that both stages share.
struct RunState {
  // For the caller: the place of the photographs and the given options. Stored unchanged.
  std::string origin = {};
  Stage stage = Stage::kAdam;
  int iteration = 0;                     // of the stage
  std::uint64_t scene = 0;               // FingerprintOf the scene
  double seconds = 0, eval_seconds = 0;  // of the training; of its evaluations
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

// A hash of the views' names, sizes, cameras and roles.
std::uint64_t FingerprintOf(const Scene& scene);

// Writes the file atomically (kernels/core/files.h): an older file stays until the new one is complete. The state is
// streamed. Throws Error (one line, with the path).
void WriteCheckpoint(const std::string& path, RunState& run, const std::function<void(ArchiveWriter&)>& stage_state);

// True if the file starts like a checkpoint; false if it cannot be read.
bool IsCheckpoint(const std::string& path);

// Throws Error (one line, with the path) if the file is missing, not a checkpoint, of another version, truncated or
// damaged.
Checkpoint ReadCheckpoint(const std::string& path);

// The saved stage that a training resumes from.
class SavedStage {
 public:
  // null: the training begins with Adam's first iteration. Must outlive this object.
  explicit SavedStage(const Checkpoint* checkpoint) : checkpoint_(checkpoint) {
    if (checkpoint) state_ = checkpoint->stage_state;  // refers to the checkpoint's memory, as the state may be large
  }

  // The stage to resume, and its finished iterations.
  Stage first_stage() const { return checkpoint_ ? checkpoint_->run.stage : Stage::kAdam; }
  int first_iteration() const { return checkpoint_ ? checkpoint_->iteration() : 0; }
  const std::string& path() const { return checkpoint_->path; }  // requires a checkpoint
  // Seconds of the training before it was saved, without evaluations; seconds of evaluations.
  double seconds() const { return checkpoint_ ? checkpoint_->run.seconds : 0; }
  double eval_seconds() const { return checkpoint_ ? checkpoint_->run.eval_seconds : 0; }

  // Empty without a checkpoint, or after Take().
  const std::optional<std::string_view>& state() const { return state_; }
  // Returns the state once if it belongs to stage `of`; else returns nothing.
  std::optional<std::string_view> Take(Stage of) {
    return of == first_stage() ? std::exchange(state_, std::nullopt) : std::nullopt;
  }
  // Returns the state for another Take().
  void GiveBack(std::optional<std::string_view> state) { state_ = state; }

  // Throws Error: the state is invalid. The message names the checkpoint and, if given, the reason.
  [[noreturn]] void Refuse(const std::string& why = "") const {
    Fail(kBadFile,
         "{}: the saved state does not fit this training{}; resume from another checkpoint, or start a new training",
         checkpoint_->path, why.empty() ? "" : fmt::format(" ({})", why));
  }
  // Returns read(). If read() throws an Error because of the saved state, calls Refuse().
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
