// SPDX-License-Identifier: Apache-2.0
// Trains very fast: renderings of a random model in a ring of views, and its noisy means as points.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "splatting/evaluate/evaluation.h"
#include "splatting/train/trainer.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs::test {

inline Scene TrainingScene(Index gaussians = 60) {
  Scene scene = RingOfCameras(12, 40, 30, true);
  RenderTruth(RandomModel(gaussians, 1, 7), 0.05, &scene);
  return scene;
}

// The last row belongs to the returned model.
inline void ExpectLastRowIsOf(const TrainResult& result, const Scene& scene, const std::array<double, 3>& background) {
  Renderer renderer(background, NearPlane(scene));
  const Evaluation e = renderer.Evaluate(result.model, scene);
  ASSERT_FALSE(result.history.empty());
  const HistoryRow& last = result.history.back();
  EXPECT_EQ(last.cost, e.cost);
  EXPECT_EQ(last.train.psnr, e.train.psnr);
  EXPECT_EQ(last.test.ssim, e.test.ssim);
  EXPECT_EQ(last.gaussians, result.model.count);
}

inline TrainOptions ShortTraining(int adam_iterations, int lm_iterations) {
  TrainOptions options;
  options.adam.iterations = adam_iterations;
  options.lm.iterations = lm_iterations;
  options.sh_degree = 1;
  options.density.every = adam_iterations > 20 ? 20.0 / adam_iterations : 1;
  options.density.max_gaussians = 100;
  options.pruning.aic_weight = options.pruning.sh_aic_weight = 0;  // they would soon remove most of so few Gaussians
  options.seed = 3;
  return options;
}

}  // namespace vesta::gs::test
