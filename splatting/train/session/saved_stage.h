// SPDX-License-Identifier: Apache-2.0
// The stage in the midst of which a training was saved, to go on from.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/device_memory.h"
#include "kernels/ranks/ranks.h"
#include "splatting/train/session/checkpoint.h"

namespace vesta::gs {

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
  auto OrRefuse(const Read& read) const {
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
