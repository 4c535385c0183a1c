// What a splat is to be rendered with, as its training has it.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/train/settings/options.h"

namespace vesta::gs {

// Has the model tell of its background and its filter.
inline void TellRenderSettings(const TrainOptions& options, SplatModel* model) {
  for (std::size_t c = 0; c < 3; ++c) model->background[c] = static_cast<float>(options.background[c]);
  model->has_background = true;
  model->low_pass = options.low_pass;
}

}  // namespace vesta::gs
