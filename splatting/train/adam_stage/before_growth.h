// The state of the Adam stage before its Gaussians last became more: what it goes back to where the memory of a device
// does not suffice for those.
#pragma once

#include <cstddef>
#include <utility>

#include "kernels/core/device_memory.h"
#include "splatting/train/adam_stage/adam_stage_state.h"
#include "splatting/train/adam_stage/kept_state.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

template <class B>
class BeforeGrowth {
 public:
  explicit BeforeGrowth(TrainingSession& session) : session_(session) {}

  bool empty() const { return kept_.empty(); }
  // On the GPU as long as that takes no room from what was planned for there.
  void Keep(AdamStageState<B>& state) {
    kept_ = Kept();
    iteration_ = state.iteration;
    const double bytes = Kept::ArrayBytes(state);
    if (bytes <= session_.memory().spare_device_bytes()) {
      try {
        kept_ = Kept(state, true);
        session_.memory().NoteKeptOnDevice(bytes);
        return;
      } catch (const OutOfDeviceMemory&) {  // less is free than was
      }
    }
    kept_ = Kept(state, false);
  }
  void Forget() { kept_ = Kept(); }
  // Once every view has been through with the Gaussians there are, there is room for them.
  void ForgetWhatHolds(int iteration) {
    const auto seen = static_cast<std::size_t>(iteration - iteration_) *
                      static_cast<std::size_t>(session_.options().adam.views_per_iteration);
    if (!empty() && seen >= 2 * session_.training_views().size()) Forget();
  }
  // Puts it back; the Gaussians stay as many from then on. Needs what was kept.
  void GoBack(AdamStageState<B>* state) {
    state->model.Free();
    // Cameras stay where they were found since, and with them what was learned of them.
    StageCamerasState cameras = std::move(state->cameras);
    kept_.MoveTo(*state);
    state->cameras = std::move(cameras);
    state->model.StayAsMany();
  }

 private:
  using Kept = KeptState<typename B::Space>;

  TrainingSession& session_;
  Kept kept_;
  int iteration_ = 0;  // that it is of
};

}  // namespace vesta::gs
