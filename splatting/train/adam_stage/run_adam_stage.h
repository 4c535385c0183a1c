// SPDX-License-Identifier: Apache-2.0
// The Adam stage from its start to its end, and what becomes of it where the memory of a device does not suffice.
#pragma once

#include <fmt/format.h>

#include <memory>

#include "kernels/core/device_memory.h"
#include "splatting/train/adam_stage/adam_stage.h"

namespace vesta::gs {

// The whole stage; leaves the model at its best and records its last state. Where the memory of a device does not
// suffice it goes on with fewer Gaussians, ends, or runs on the host, and says so in a note.
template <class B>
void RunAdamStage(TrainingSession& session, SplatModel& model) {
  for (auto stage = std::make_unique<AdamStage<B>>(session, model);;) {
    try {
      return stage->Run();
    } catch (const OutOfDeviceMemory& error) {
      const int failed = stage->iteration();
      if (stage->GoBackBeforeGrowth()) {
        session.Note(fmt::format("Adam goes on from iteration {} with {} Gaussians and no more: {}", stage->iteration(),
                                 stage->gaussians(), error.what()));
      } else if (failed > 0) {
        session.Note(fmt::format("Adam ends after {} iterations: {}", failed, error.what()));
        return stage->Finish();
      } else {
        session.Note(fmt::format("Adam runs on the CPU: {}", error.what()));
        stage->GiveBackSavedStage();
        stage.reset();
        return RunAdamStage<CpuBackend<float>>(session, model);
      }
    }
  }
}

extern template void RunAdamStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

}  // namespace vesta::gs
