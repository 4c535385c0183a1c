// SPDX-License-Identifier: Apache-2.0
// The state of a training in a file, and the stage that resumes from it, to the same bits.
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

// What both stages share.
struct RunState {
  // The caller's: where the photographs lie and which options were given. Kept as it is.
  std::string origin = {};
  Stage stage = Stage::kAdam;
  int iteration = 0;                     // of the stage
  std::uint64_t scene = 0;               // FingerprintOf the scene
  double seconds = 0, eval_seconds = 0;  // of the training, and of its evaluations
  std::vector<HistoryRow> history = {};
  std::vector<std::string> notes = {};
  std::vector<ViewUnknowns> cameras = {};  // of the training views, where they are found along; else empty

  template <class Archive>
  void Visit(Archive& archive) {
    archive(origin, stage, iteration, scene, seconds, eval_seconds, history, notes, cameras);
  }
};

struct Checkpoint {
  std::string path;  // for messages
  RunState run;
  std::string stage_state;  // of the stage that the training was in

  int iteration() const { return run.iteration; }
};

// A number that views with other names, sizes, cameras or roles are unlikely to share.
std::uint64_t FingerprintOf(const Scene& scene);

// Whole or not at all (kernels/core/files.h): an older file of that name stays until the new one is complete. Passes
// the state on as it comes. Throws Error, one line naming the path.
void WriteCheckpoint(const std::string& path, RunState& run, const std::function<void(ArchiveWriter&)>& stage_state);

// Whether the file begins as one; false, too, where it cannot be read.
bool IsCheckpoint(const std::string& path);

// Throws Error, one line that names the file, where it is missing, no checkpoint, of another version, cut short or
// damaged.
Checkpoint ReadCheckpoint(const std::string& path);

// The stage in the midst of which a training was saved, to go on from.
class SavedStage {
 public:
  // null: nothing was saved, the training begins with Adam's first iteration. Must outlive this.
  explicit SavedStage(const Checkpoint* checkpoint) : checkpoint_(checkpoint) {
    if (checkpoint) state_ = checkpoint->stage_state;  // in its memory, as it may be large
  }

  // Where the training begins, and how many iterations of that stage are done.
  Stage first_stage() const { return checkpoint_ ? checkpoint_->run.stage : Stage::kAdam; }
  int first_iteration() const { return checkpoint_ ? checkpoint_->iteration() : 0; }
  const std::string& path() const { return checkpoint_->path; }  // where something was saved
  // That it had taken until then, and its evaluations beside that.
  double seconds() const { return checkpoint_ ? checkpoint_->run.seconds : 0; }
  double eval_seconds() const { return checkpoint_ ? checkpoint_->run.eval_seconds : 0; }

  // None where nothing was saved, or it has been taken.
  const std::optional<std::string_view>& state() const { return state_; }
  // The state of this stage, once; none where the stage begins anew.
  std::optional<std::string_view> Take(Stage of) {
    return of == first_stage() ? std::exchange(state_, std::nullopt) : std::nullopt;
  }
  // For another to take.
  void GiveBack(std::optional<std::string_view> state) { state_ = state; }

  // Where it cannot be one: throws Error, which names the checkpoint, and why where that is known.
  [[noreturn]] void Refuse(const std::string& why = "") const {
    Fail(kBadFile,
         "{}: holds no state that this training could have had{}; resume from another checkpoint, or train anew",
         checkpoint_->path, why.empty() ? "" : fmt::format(" ({})", why));
  }
  // What read() returns; where it throws for what was saved, so does Refuse.
  template <class Read>
  auto Validate(const Read& read) const {
    try {
      return read();
    } catch (const OutOfDeviceMemory&) {
      throw;
    } catch (const OthersGaveUp&) {
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
