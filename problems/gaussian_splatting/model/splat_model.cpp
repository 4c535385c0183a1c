// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

std::vector<Index> GaussiansWithin(const SplatModel& model, const Box& box) {
  std::vector<Index> within;
  for (Index i = 0; i < model.count; ++i) {
    bool is_within = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const float* means = model.attribute(splat::kMean + static_cast<int>(k));
      const double at = static_cast<double>(means[i]) + model.origin[k];
      is_within = is_within && at >= box.low[k] && at <= box.high[k];
    }
    if (is_within) within.push_back(i);
  }
  return within;
}

}  // namespace vesta::gs
