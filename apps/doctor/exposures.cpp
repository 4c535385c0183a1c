// SPDX-License-Identifier: Apache-2.0
#include "apps/doctor/exposures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <unordered_map>

#include "kernels/gaussian_splatting/lenses/models.h"

namespace vesta::app {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Index kSample = 5000;      // at most about this many points
constexpr std::size_t kFewest = 20;  // points for a reliable estimate

// log2 of the light of a colour with channels 0..1; NaN if too dark or too bright.
double Stops(double red, double green, double blue) {
  const double luma = Luma(red, green, blue);
  return luma > 0.04 && luma < 0.98 ? 2.2 * std::log2(luma) : kNaN;
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

// The light of a point's pixel, in stops; NaN if the point is not in the image, or the pixel too dark or too bright.
double StopsAt(const gs::View& view, const gs::Image& photograph, const std::array<float, 3>& point) {
  if (!(gs::DepthInView(view, point) > 0)) return kNaN;
  const std::size_t pixel = PixelOf(view, point);
  const auto channel = [&](int c) { return static_cast<double>(photograph.plane(c)[pixel]); };
  return Stops(channel(0), channel(1), channel(2));
}

// Quartiles of the brightness differences of a view's points; NaN with too few points.
struct Quartiles {
  double low = kNaN, middle = kNaN, high = kNaN;
};

Quartiles DifferencesOf(const gs::View& view, const gs::PointCloud& points) {
  std::vector<double> differences;
  const std::shared_ptr<const gs::Image> photograph = view.Photograph();
  const Index stride = std::max<Index>(1, points.size() / kSample);
  for (Index i = 0; i < points.size(); i += stride) {
    const auto& point = points.positions[static_cast<std::size_t>(i)];
    const auto& color = points.colors[static_cast<std::size_t>(i)];
    const double difference =
        StopsAt(view, *photograph, point) -
        Stops(static_cast<double>(color[0]), static_cast<double>(color[1]), static_cast<double>(color[2]));
    if (std::isfinite(difference)) differences.push_back(difference);
  }
  if (differences.size() < kFewest) return {};
  std::sort(differences.begin(), differences.end());
  const std::size_t count = differences.size();
  return {differences[count / 4], differences[count / 2], differences[count - 1 - count / 4]};
}

// The brightness of a point in a view.
struct Sample {
  std::size_t point, view;
  double stops;
};

// The samples of all tracks, by view.
std::vector<Sample> SamplesOfTracks(const gs::Scene& scene, const gs::PointTracks& tracks) {
  std::unordered_map<std::uint32_t, std::size_t> view_of;
  std::vector<std::vector<std::size_t>> points_of(scene.views.size());
  for (std::size_t i = 0; i < scene.views.size(); ++i) view_of[scene.views[i].id] = i;
  for (std::size_t p = 0; p < tracks.size(); ++p) {
    for (const std::uint32_t id : tracks[p]) {
      if (const auto found = view_of.find(id); found != view_of.end()) points_of[found->second].push_back(p);
    }
  }
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const std::shared_ptr<const gs::Image> photograph = scene.views[i].Photograph();
    for (const std::size_t p : points_of[i]) {
      const double stops = StopsAt(scene.views[i], *photograph, scene.points.positions[p]);
      if (std::isfinite(stops)) samples.push_back({p, i, stops});
    }
  }
  return samples;
}

// The median of the values of each group; NaN for groups with fewer than `fewest` values.
std::vector<double> Medians(std::vector<std::vector<double>> groups, std::size_t fewest) {
  std::vector<double> medians(groups.size(), kNaN);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    if (groups[k].size() >= fewest) medians[k] = gs::Median(std::move(groups[k]));
  }
  return medians;
}

std::vector<double> StopsOfTracks(const gs::Scene& scene, const gs::PointTracks& tracks) {
  constexpr int kRounds = 20;
  const std::vector<Sample> samples = SamplesOfTracks(scene, tracks);
  std::vector<double> exposures(scene.views.size(), 0.0);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<std::vector<double>> groups(tracks.size());
    for (const Sample& one : samples) {
      if (std::isfinite(exposures[one.view])) groups[one.point].push_back(one.stops - exposures[one.view]);
    }
    const std::vector<double> brightness = Medians(std::move(groups), 2);
    groups.assign(scene.views.size(), {});
    for (const Sample& one : samples) {
      if (std::isfinite(brightness[one.point])) groups[one.view].push_back(one.stops - brightness[one.point]);
    }
    exposures = Medians(std::move(groups), kFewest);
  }
  return exposures;
}

std::vector<double> Finite(const std::vector<double>& values) {
  std::vector<double> finite;
  std::ranges::copy_if(values, std::back_inserter(finite), [](double value) { return std::isfinite(value); });
  return finite;
}

}  // namespace

std::vector<double> ExposureStops(const gs::Scene& scene, const gs::PointTracks& tracks) {
  std::vector<double> stops;
  std::vector<Quartiles> quartiles;
  if (tracks.empty()) {
    for (const gs::View& view : scene.views) quartiles.push_back(DifferencesOf(view, scene.points));
    for (const Quartiles& of : quartiles) stops.push_back(of.middle);
  } else {
    stops = StopsOfTracks(scene, tracks);
  }
  const std::vector<double> known = Finite(stops);
  const double usual = known.empty() ? 0 : gs::Median(known);
  for (double& one : stops) one -= usual;
  for (std::size_t i = 0; i < quartiles.size(); ++i) {
    if ((quartiles[i].low - usual) * (quartiles[i].high - usual) <= 0) stops[i] = 0;
  }
  return stops;
}

double ExposureSpread(const std::vector<double>& stops) {
  std::vector<double> known = Finite(stops);
  if (known.size() < 2) return kNaN;
  std::ranges::sort(known);
  const auto at = [&](double fraction) {
    return known[static_cast<std::size_t>(std::lround(fraction * static_cast<double>(known.size() - 1)))];
  };
  return std::exp2((at(0.95) - at(0.05)) / 2.2) - 1;
}

}  // namespace vesta::app
