// SPDX-License-Identifier: Apache-2.0
// Pruning before a training that cannot prune gradually, for `vesta prune` and vesta.prune.
#pragma once

#include <optional>
#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// With max_loss (PruneGoal::max_rise), or if Adam has too few iterations to prune gradually: prunes the model at once,
// and turns off pruning in the options. Otherwise changes nothing. model: in the scene's frame. Returns a line for the
// user; empty if it changed nothing.
std::string PruneAtStart(const Scene& scene, std::optional<double> max_loss, TrainOptions& options, SplatModel& model);

}  // namespace vesta::gs
