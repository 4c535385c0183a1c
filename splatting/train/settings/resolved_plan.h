// SPDX-License-Identifier: Apache-2.0
// What the program decides beside the options: by the scene, by the memory there is, and as the training goes.
#pragma once

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Iterations of Adam that this many training views require: 4,000, as long as each view has its turn 76 times, and
// else as many as that takes (docs/results/2026-11-24-length.md).
double IterationsFor(Index training_views);

// The options with every std::optional filled in: iterations and degree of the harmonics. Under a time limit time alone
// ends the Adam stage, unless iterations are given. Throws Error where the options are not valid, or an iteration is to
// take more views than there are.
TrainOptions FitToScene(TrainOptions options, Index training_views);

// The decisions of one training. Its options never change.
struct ResolvedPlan {
  explicit ResolvedPlan(const TrainOptions& options) : max_gaussians(options.density.max_gaussians), lm(options.lm) {}

  double held_mib = 0;  // memory of the process beside the stages: the program, images, copies of cameras
  Index max_gaussians;  // density.max_gaussians, or fewer where memory is limited
  LmStageOptions lm;    // as the LM stage runs; 0 iterations: it does not
  LmPlan lm_memory;     // how it runs within the memory
};

}  // namespace vesta::gs
