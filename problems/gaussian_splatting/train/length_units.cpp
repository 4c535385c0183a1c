#include "problems/gaussian_splatting/train/length_units.h"

#include <algorithm>
#include <limits>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"

namespace vesta::gs {
namespace {

constexpr std::size_t kMostViews = 64;

// The depth of point x where the view's image holds it; infinity elsewhere.
double DepthInImage(const splat::PinholeView& view, const double x[3]) {
  double p[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = view.R[3 * i] * x[0] + view.R[3 * i + 1] * x[1] + view.R[3 * i + 2] * x[2] + view.T[i];
  }
  const double u = view.fx * p[0] + view.cx * p[2], v = view.fy * p[1] + view.cy * p[2];
  const bool inside = p[2] > view.near && u >= 0 && u <= view.width * p[2] && v >= 0 && v <= view.height * p[2];
  return inside ? p[2] : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<float> LengthUnits(const SplatModel& model, const std::vector<splat::PinholeView>& views,
                               double otherwise) {
  std::vector<splat::PinholeView> chosen;
  const std::size_t most = std::min(kMostViews, views.size());
  for (std::size_t k = 0; k < most; ++k) chosen.push_back(views[k * views.size() / most]);
  std::vector<float> units(static_cast<std::size_t>(model.count));
  ParallelFor(model.count, 256, [&](Index i) {
    double x[3], depth = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) x[k] = model.attribute(splat::kMean + k)[i];
    for (const splat::PinholeView& view : chosen) depth = std::min(depth, DepthInImage(view, x));
    units[static_cast<std::size_t>(i)] = static_cast<float>(depth < 1e30 ? 0.5 * depth : otherwise);
  });
  return units;
}

}  // namespace vesta::gs
