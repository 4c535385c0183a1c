// SPDX-License-Identifier: Apache-2.0
// Trainings resumed from their checkpoint.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <optional>

#include "splatting/train/trainer.h"
#include "tests/support/temp_folder.h"

namespace vesta::gs::test {

using TrainBy = std::function<TrainResult(const TrainCallbacks&)>;

// After `stop` iterations, of `stage` if given.
inline Checkpoint StoppedAt(int stop, const TrainBy& train, std::optional<Stage> stage = std::nullopt) {
  const TempFolder folder;
  TrainCallbacks callbacks;
  int reached = 0;
  callbacks.progress = [&](const TrainProgress& p) { reached = p.stage == stage.value_or(p.stage) ? p.iteration : 0; };
  callbacks.stop = [&] { return reached >= stop; };
  callbacks.checkpoint = {.path = folder / "checkpoint", .every = {.iterations = 1}, .origin = ""};
  EXPECT_TRUE(train(callbacks).stopped);
  return ReadCheckpoint(folder / "checkpoint");
}

inline TrainResult ResumeFrom(const Checkpoint& checkpoint, const TrainBy& train) {
  TrainCallbacks callbacks;
  callbacks.resume = &checkpoint;
  return train(callbacks);
}

}  // namespace vesta::gs::test
