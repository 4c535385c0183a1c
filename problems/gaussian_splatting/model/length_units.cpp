// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/length_units.h"

#include <algorithm>

#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {

std::vector<splat::PosedCamera> LengthUnitViews(const std::vector<const View*>& views, double near) {
  constexpr std::size_t kMostViews = 64;
  const std::size_t most = std::min(kMostViews, views.size());
  std::vector<splat::PosedCamera> chosen;
  for (std::size_t k = 0; k < most; ++k) chosen.push_back(ToPosedCamera(*views[k * views.size() / most], near));
  return chosen;
}

std::vector<float> LengthUnits(const SplatModel& model, const std::vector<const View*>& views, double near,
                               double otherwise) {
  const std::vector<splat::PosedCamera> chosen = LengthUnitViews(views, near);
  std::vector<float> units(static_cast<std::size_t>(model.count));
  ForEach<Host>(model.count, 256,
                MeasureUnit{model.count, model.data.data(), chosen.data(), static_cast<Index>(chosen.size()), otherwise,
                            units.data()});
  return units;
}

}  // namespace vesta::gs
