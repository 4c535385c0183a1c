// SPDX-License-Identifier: Apache-2.0
#include "apps/doctor/exposures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "apps/doctor/scene_warnings.h"
#include "kernels/gaussian_splatting/lenses/models.h"

namespace vesta::app {
namespace {

constexpr Index kSample = 5000;      // at most about this many points
constexpr std::size_t kFewest = 20;  // points for a reliable estimate

// log2 of the light of a colour with channels 0..1; NaN if too dark or too bright.
double Stops(double red, double green, double blue) {
  const double luma = Luma(red, green, blue);
  return luma > 0.04 && luma < 0.98 ? 2.2 * std::log2(luma) : std::numeric_limits<double>::quiet_NaN();
}

// The pixel of a point inside the image.
std::size_t PixelOf(const gs::View& view, const std::array<float, 3>& point) {
  const auto t =
      gs::InCamera(view, {static_cast<double>(point[0]), static_cast<double>(point[1]), static_cast<double>(point[2])});
  double u = 0, v = 0;
  splat::PixelOf(view.camera.lens, t.data(), u, v);
  const int x = std::clamp(static_cast<int>(u), 0, view.camera.width - 1);
  const int y = std::clamp(static_cast<int>(v), 0, view.camera.height - 1);
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(view.camera.width) + static_cast<std::size_t>(x);
}

// Quartiles of the brightness differences of a view's points; NaN with too few points.
struct Quartiles {
  double low = std::numeric_limits<double>::quiet_NaN(), middle = low, high = low;
};

Quartiles DifferencesOf(const gs::View& view, const gs::PointCloud& points) {
  std::vector<double> differences;
  const std::shared_ptr<const gs::Image> photograph = view.Photograph();
  const Index stride = std::max<Index>(1, points.size() / kSample);
  for (Index i = 0; i < points.size(); i += stride) {
    const auto& point = points.positions[static_cast<std::size_t>(i)];
    const auto& color = points.colors[static_cast<std::size_t>(i)];
    if (!(gs::DepthInView(view, point) > 0)) continue;
    const std::size_t pixel = PixelOf(view, point);
    const auto channel = [&](int c) { return static_cast<double>(photograph->plane(c)[pixel]); };
    const double difference =
        Stops(channel(0), channel(1), channel(2)) -
        Stops(static_cast<double>(color[0]), static_cast<double>(color[1]), static_cast<double>(color[2]));
    if (std::isfinite(difference)) differences.push_back(difference);
  }
  if (differences.size() < kFewest) return {};
  std::sort(differences.begin(), differences.end());
  const std::size_t count = differences.size();
  return {differences[count / 4], differences[count / 2], differences[count - 1 - count / 4]};
}

}  // namespace

std::vector<ViewExposure> ExposuresOf(const gs::Scene& scene) {
  std::vector<Quartiles> quartiles;
  std::vector<double> known;
  for (const gs::View& view : scene.views) {
    quartiles.push_back(DifferencesOf(view, scene.points));
    if (std::isfinite(quartiles.back().middle)) known.push_back(quartiles.back().middle);
  }
  const double usual = known.empty() ? 0 : gs::Median(std::move(known));
  std::vector<ViewExposure> exposures;
  exposures.reserve(quartiles.size());
  for (const Quartiles& of : quartiles) {
    exposures.push_back({of.middle - usual, (of.low - usual) * (of.high - usual) > 0});
  }
  return exposures;
}

double ExposureSpread(const std::vector<ViewExposure>& exposures) {
  constexpr std::size_t kFewestViews = 5;
  std::vector<double> stops;
  for (const ViewExposure& view : exposures) {
    if (std::isfinite(view.stops)) stops.push_back(view.stops);
  }
  if (stops.size() < kFewestViews) return 0;
  std::sort(stops.begin(), stops.end());
  const std::size_t tenth = stops.size() / 10;
  return stops[stops.size() - 1 - tenth] - stops[tenth];
}

double LightPercent(double stops) { return 100 * (std::exp2(stops) - 1); }

}  // namespace vesta::app
