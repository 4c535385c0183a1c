// SPDX-License-Identifier: Apache-2.0
// What a scene requires, where the options leave it open.
#pragma once

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Iterations of Adam that this many training views require: 4,000, as long as each view has its turn 76 times, and
// else as many as that takes (docs/results/2026-11-24-length.md).
double IterationsFor(Index training_views);

// The options with every std::optional filled in: iterations and degree of the harmonics. Under a time limit time alone
// ends the Adam stage, unless iterations are given. Throws Error where the options are not valid, or an iteration is to
// take more views than there are.
TrainOptions FitToScene(TrainOptions options, Index training_views);

}  // namespace vesta::gs
