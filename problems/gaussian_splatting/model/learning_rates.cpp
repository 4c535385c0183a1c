// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/learning_rates.h"

namespace vesta::gs {

const schema::Table<LearningRates>& LearningRateFields() {
  using O = LearningRates;
  constexpr schema::Range kRate{1e-12, 1e3};
  static const schema::Table<O> fields = {
      {"position", &O::position, kRate, "learning rate of the means, in units of length"},
      {"log_scale", &O::log_scale, kRate, "of the logarithms of the scales"},
      {"quaternion", &O::quaternion, kRate, "of the rotations"},
      {"opacity", &O::opacity, kRate, "of the logit of the opacity"},
      {"sh_dc", &O::sh_dc, kRate, "of the harmonics' constant"},
      {"sh_rest", &O::sh_rest, kRate, "of the bands above it"},
  };
  return fields;
}

}  // namespace vesta::gs
