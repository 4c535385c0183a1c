// SPDX-License-Identifier: Apache-2.0
// Training with the density control of 3DGS-MCMC (Kheradmand et al. 2024, "3D Gaussian Splatting as Markov Chain Monte
// Carlo"). The number of Gaussians is fixed. Gaussians of low opacity move to others, and noise moves the means. The
// rest is vesta's Adam stage without pruning.
#pragma once

#include "splatting/train/trainer.h"

namespace vesta::bench {

// Published values; positions and lengths in scene extents. The published training has 30,000 iterations, of which
// iterations 500 to 25,000 relocate.
struct McmcOptions {
  Index gaussians = 0;                                  // the number to reach
  double begin = 500.0 / 30000, end = 25000.0 / 30000;  // of the stage
  int every = 100;                                      // iterations between relocations
  // Least growth per relocation. It is larger if that is needed to reach the number by the middle of the stage.
  double growth = 0.05;
  double min_opacity = 0.005;
  double noise = 5e5;  // factor on the learning rate of positions
  // Penalties on mean opacity and mean standard deviation, beside the loss per pixel value.
  double opacity_penalty = 0.01, scale_penalty = 0.01;
};

// The shape of `copies` equal Gaussians that replace one Gaussian in its place and hardly change its image (equation
// 9). scale: factor on the standard deviation.
struct SharedShape {
  double opacity, scale;
};
SharedShape ShapeOfCopies(double opacity, int copies);

struct McmcResult {
  gs::Evaluation evaluation;
  Index gaussians = 0;
};
// options: from FitToScene.
McmcResult TrainByMcmc(const gs::Scene& scene, const gs::TrainOptions& options, const McmcOptions& mcmc);

}  // namespace vesta::bench
