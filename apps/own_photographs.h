// Of several processes each reads its own photographs.
#pragma once

#include "apps/ranks.h"
#include "problems/gaussian_splatting/io/load_scene.h"
#include "problems/gaussian_splatting/train/options.h"
#include "problems/gaussian_splatting/train/over_ranks.h"

namespace vesta::app {

// Where each trains on its own views; with a single view at a time all train on each.
inline gs::LoadSceneOptions ReadingOwn(gs::LoadSceneOptions scene, const gs::TrainOptions& options) {
  if (gs::AllTrainOnEach(options)) return scene;
  scene.process = WorldRanks().rank(), scene.processes = WorldRanks().size();
  return scene;
}

}  // namespace vesta::app
