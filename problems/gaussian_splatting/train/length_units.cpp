#include "problems/gaussian_splatting/train/length_units.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"

namespace vesta::gs {

std::vector<float> LengthUnits(const SplatModel& model, const std::vector<const View*>& views, double near,
                               double otherwise) {
  constexpr std::size_t kMostViews = 64;
  const std::size_t most = std::min(kMostViews, views.size());
  std::vector<float> units(static_cast<std::size_t>(model.count));
  ParallelFor(model.count, 256, [&](Index i) {
    const auto mean = [&](int k) { return model.attribute(splat::kMean + k)[i]; };
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < most; ++k) {
      const double depth = DepthInView(*views[k * views.size() / most], {mean(0), mean(1), mean(2)});
      if (depth > near) nearest = std::min(nearest, depth);
    }
    units[static_cast<std::size_t>(i)] = static_cast<float>(std::isfinite(nearest) ? 0.5 * nearest : otherwise);
  });
  return units;
}

}  // namespace vesta::gs
