// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/learning_rates.h"

namespace vesta::gs {

const schema::Table<LearningRates>& LearningRateFields() {
  using O = LearningRates;
  constexpr schema::Range kRate{1e-12, 1e3};
  static const schema::Table<O> fields = {
      {"position", &O::position, kRate,
       "learning rate of the means, in units of half their depth in the nearest view; as all lr.*, times "
       "adam.lr_scale"},
      {"log_scale", &O::log_scale, kRate, "learning rate of the logarithms of the scales"},
      {"quaternion", &O::quaternion, kRate, "learning rate of the rotation quaternions"},
      {"opacity", &O::opacity, kRate, "learning rate of the logit of the opacity"},
      {"sh_dc", &O::sh_dc, kRate, "learning rate of the constant SH coefficients"},
      {"sh_rest", &O::sh_rest, kRate, "learning rate of the SH coefficients above degree 0"},
  };
  return fields;
}

}  // namespace vesta::gs
