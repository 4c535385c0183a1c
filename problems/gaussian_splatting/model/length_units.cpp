#include "problems/gaussian_splatting/model/length_units.h"

#include <algorithm>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"
#include "problems/gaussian_splatting/model/length_unit_formula.h"
#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::gs {

std::vector<splat::PinholeView> UnitViews(const std::vector<const View*>& views, double near) {
  constexpr std::size_t kMostViews = 64;
  const std::size_t most = std::min(kMostViews, views.size());
  std::vector<splat::PinholeView> chosen;
  for (std::size_t k = 0; k < most; ++k) chosen.push_back(ToPinhole(*views[k * views.size() / most], near));
  return chosen;
}

std::vector<float> LengthUnits(const SplatModel& model, const std::vector<const View*>& views, double near,
                               double otherwise) {
  const std::vector<splat::PinholeView> chosen = UnitViews(views, near);
  std::vector<float> units(static_cast<std::size_t>(model.count));
  ParallelFor(model.count, 256, [&](Index i) {
    float mean[3];
    for (int k = 0; k < 3; ++k) mean[k] = model.attribute(splat::kMean + k)[i];
    units[static_cast<std::size_t>(i)] = LengthUnit(chosen.data(), static_cast<Index>(chosen.size()), otherwise, mean);
  });
  return units;
}

}  // namespace vesta::gs
