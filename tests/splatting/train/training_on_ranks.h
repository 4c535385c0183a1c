// SPDX-License-Identifier: Apache-2.0
// Trainings by several processes, which are threads of the test.
#pragma once

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/splatting/train/training_scene.h"
#include "tests/support/thread_ranks.h"

namespace vesta::gs::test {

// With views that judge, evaluated once on the way.
inline TrainOptions TrainingOnRanks(int iterations, int lm_iterations) {
  TrainOptions options = ShortTraining(iterations, lm_iterations);
  options.adam.evaluations = 2;
  options.pruning = PruningOptions();
  options.adam.batch_size = 3;
  return options;
}

// By all of them the same; of the first.
inline TrainResult TrainOn(int count, const Scene& scene, const TrainOptions& options,
                           const StageRunners& stages = HostStages()) {
  std::vector<TrainResult> all(static_cast<std::size_t>(count));
  vesta::test::OnThreadRanks(count, [&](Communicator& ranks) {
    TrainCallbacks callbacks;
    callbacks.ranks = &ranks;
    all[static_cast<std::size_t>(ranks.rank())] = Train(scene, options, {}, callbacks, stages);
  });
  for (const TrainResult& result : all) {
    EXPECT_EQ(result.model.data, all[0].model.data);
    EXPECT_EQ(result.history.back().test.psnr, all[0].history.back().test.psnr);
    EXPECT_EQ(result.history.back().cost, all[0].history.back().cost);
  }
  return std::move(all[0]);
}

}  // namespace vesta::gs::test
