// SPDX-License-Identifier: Apache-2.0
// Rendering and measuring threads do not change a training.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "apps/viewer/frame_renderer.h"
#include "apps/viewer/gaussian_values.h"
#include "apps/viewer/training_monitor.h"
#include "kernels/core/parallel.h"
#include "splatting/train/trainer.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::app {
namespace {

TEST(ViewerThreads, DrawWhileATrainingGoesOn) {
  gs::Scene scene = gs::test::RingOfCameras(12, 40, 30, true);
  gs::test::RenderTruth(gs::test::RandomModel(60, 1, 7), 0.05, &scene);
  gs::TrainOptions options;
  options.adam.iterations = 120;
  options.lm.iterations = 2;
  const int before = NumThreads();
  SetNumThreads(2);
  const gs::TrainResult alone = gs::Train(scene, options, {}, {});

  ShownModel shown;
  TrainingMonitor monitor(shown);
  FrameRenderer renderer(scene, {0, 0, 0});
  GaussianValues values(scene, {0, 0, 0});
  std::atomic<bool> is_over{false};
  std::atomic<int> drawn{0};
  const auto look = [&] {
    const FrameRequest request =
        ParseFrameRequest({{"kind", "difference"}, {"photo", "1"}, {"width", "40"}, {"height", "30"}}, scene);
    while (!is_over) {
      const ShownModel::Shown now = shown.Get();
      if (now.model) values.Get(GaussianValue::kRemovalCost, now);
      if (now.model && !renderer.Jpeg(*now.model, request).empty()) ++drawn;
      EXPECT_FALSE(monitor.StateJson().empty());
    }
  };
  gs::TrainCallbacks callbacks;
  monitor.Follow(&callbacks);
  // At least one image, even of a very fast training.
  callbacks.watch.wants_model = [] { return true; };
  const auto waits = callbacks.watch.waits;
  callbacks.watch.waits = [&] { return waits() || drawn == 0; };
  std::thread first(look), second(look);
  const gs::TrainResult watched = gs::Train(scene, options, {}, callbacks);
  is_over = true;
  first.join(), second.join();
  SetNumThreads(before);
  EXPECT_GT(drawn, 0);
  EXPECT_EQ(watched.model.data, alone.model.data);
}

}  // namespace
}  // namespace vesta::app
