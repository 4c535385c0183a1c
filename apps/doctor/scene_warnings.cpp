// SPDX-License-Identifier: Apache-2.0
#include "apps/doctor/scene_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "apps/doctor/exposures.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {
namespace {

constexpr int kMaxWidth = 640;

std::vector<double> LumaOf(const gs::Image& image) {
  std::vector<double> luma(image.num_pixels());
  const auto channel = [&](int c, std::size_t i) { return static_cast<double>(image.plane(c)[i]); };
  for (std::size_t i = 0; i < luma.size(); ++i) luma[i] = Luma(channel(0, i), channel(1, i), channel(2, i));
  return luma;
}

double MeanSquaredLaplacian(const std::vector<double>& luma, int width, int height) {
  double sum = 0;
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      const double* at = luma.data() + static_cast<std::ptrdiff_t>(y) * width + x;
      const double laplacian = 4 * at[0] - at[-1] - at[1] - at[-width] - at[width];
      sum += laplacian * laplacian;
    }
  }
  const int inside = (width - 2) * (height - 2);
  return inside > 0 ? sum / inside : 0;
}

bool IsSaturated(const gs::Image& image, std::size_t pixel) {
  constexpr int kTop = 254;
  const auto is_at_top = [&](int c) { return gs::QuantizeColor(image.plane(c)[pixel]) >= kTop; };
  return is_at_top(0) || is_at_top(1) || is_at_top(2);
}

// Pixels of small images are repeated.
std::vector<float> ThumbnailOf(const gs::Image& image) {
  const gs::Image small = gs::ResizeArea(image, std::min(image.width, kThumbnail), std::min(image.height, kThumbnail));
  std::vector<float> pixels;
  pixels.reserve(3 * kThumbnail * kThumbnail);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kThumbnail; ++y) {
      const float* row = small.plane(c) + static_cast<std::ptrdiff_t>(y * small.height / kThumbnail) * small.width;
      for (int x = 0; x < kThumbnail; ++x) pixels.push_back(row[x * small.width / kThumbnail]);
    }
  }
  return pixels;
}

// Thresholds for warnings.
constexpr Index kFewViews = 10, kFewPoints = 500, kFewSeen = 20;
constexpr double kSameThumbnail = 1.0 / 255;  // mean difference
constexpr double kBlurred = 0.25;             // sharpness / median sharpness of the views
constexpr double kStops = 0.6;                // exposure relative to the median view
constexpr double kSaturated = 0.2;            // fraction of the pixels
constexpr double kFlat = 2.0 / 255;           // contrast
constexpr Index kCountedPoints = 20000;       // tested per view, about

// Warnings about single views; only the first few are printed.
class Findings {
 public:
  void Add(std::string line) { lines_.push_back(std::move(line)); }
  void AppendTo(std::vector<std::string>* warnings, const char* more) {
    constexpr std::size_t kMost = 5;
    const std::size_t rest = lines_.size() > kMost ? lines_.size() - kMost : 0;
    lines_.resize(std::min(lines_.size(), kMost));
    warnings->insert(warnings->end(), lines_.begin(), lines_.end());
    if (rest > 0) warnings->push_back(fmt::format("and {} more {}", rest, more));
  }

 private:
  std::vector<std::string> lines_;
};

void WarnOfNumbers(const gs::Scene& scene, std::vector<std::string>* warnings) {
  const auto views = static_cast<Index>(scene.views.size());
  if (views < kFewViews)
    warnings->push_back(fmt::format("only {} views: more photographs, from all around, help most", views));
  if (scene.points.size() < kFewPoints) {
    warnings->push_back(
        fmt::format("only {} points to start from: did the reconstruction succeed?", scene.points.size()));
  }
}

void WarnOfSeen(const gs::Scene& scene, std::vector<std::string>* warnings) {
  Findings findings;
  const Index stride = std::max<Index>(1, scene.points.size() / kCountedPoints);
  for (const gs::View& view : scene.views) {
    Index seen = 0;
    for (Index i = 0; i < scene.points.size(); i += stride) {
      if (gs::DepthInView(view, scene.points.positions[static_cast<std::size_t>(i)]) > 0) seen += stride;
    }
    if (seen < kFewSeen)
      findings.Add(fmt::format("{}: sees only {} of the points: is its pose right?", view.name, seen));
  }
  findings.AppendTo(warnings, "views that see few points");
}

void WarnOfDuplicates(const gs::Scene& scene, const std::vector<ViewDiagnostics>& diagnostics,
                      std::vector<std::string>* warnings) {
  Findings findings;
  for (std::size_t i = 0; i < diagnostics.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (ThumbnailDistance(diagnostics[i], diagnostics[j]) >= kSameThumbnail) continue;
      findings.Add(fmt::format("{}: nearly the same photograph as {}", scene.views[i].name, scene.views[j].name));
      break;  // report only the first match
    }
  }
  findings.AppendTo(warnings, "photographs that are nearly the same as another");
}

void WarnOfPoses(const gs::Scene& scene, std::vector<std::string>* warnings) {
  constexpr double kNear = 1e-6;
  Findings findings;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const gs::View& view = scene.views[i];
    const auto center = gs::CameraCenter(view);
    for (std::size_t j = 0; j < i; ++j) {
      const auto other = gs::CameraCenter(scene.views[j]);
      double distance = 0, turn = 0;
      for (std::size_t k = 0; k < 3; ++k) distance = std::max(distance, std::abs(center[k] - other[k]));
      for (std::size_t k = 0; k < 9; ++k)
        turn = std::max(turn, std::abs(view.rotation[k] - scene.views[j].rotation[k]));
      if (distance > kNear * scene.extent || turn > kNear) continue;
      findings.Add(fmt::format("{}: has the same pose as {}", view.name, scene.views[j].name));
      break;
    }
  }
  findings.AppendTo(warnings, "views with the same pose as another");
}

void WarnOfPhotographs(const gs::Scene& scene, const gs::PointTracks& tracks,
                       const std::vector<ViewDiagnostics>& diagnostics, std::vector<std::string>* warnings) {
  std::vector<double> sharpness;
  sharpness.reserve(diagnostics.size());
  for (const ViewDiagnostics& one : diagnostics) sharpness.push_back(one.sharpness);
  const double usual_sharpness = gs::Median(std::move(sharpness));
  const std::vector<double> stops_of = ExposureStops(scene, tracks);
  Findings flat, blurred, exposed, saturated;
  for (std::size_t i = 0; i < diagnostics.size(); ++i) {
    const ViewDiagnostics& one = diagnostics[i];
    const std::string& name = scene.views[i].name;
    const double stops = stops_of[i];
    if (one.contrast < kFlat) {
      flat.Add(fmt::format("{}: has a single colour", name));
      continue;
    }
    if (one.sharpness < kBlurred * usual_sharpness) {
      blurred.Add(fmt::format("{}: blurred? Its sharpness is {:.0f} % of the median", name,
                              100 * one.sharpness / usual_sharpness));
    }
    if (std::abs(stops) > kStops) {
      exposed.Add(
          fmt::format("{}: {:.1f} stops {} than the others", name, std::abs(stops), stops < 0 ? "darker" : "lighter"));
    }
    if (one.saturated > kSaturated) {
      saturated.Add(fmt::format("{}: {:.0f} % of its pixels are saturated in a channel", name, 100 * one.saturated));
    }
  }
  flat.AppendTo(warnings, "photographs of one colour");
  blurred.AppendTo(warnings, "photographs that may be blurred");
  exposed.AppendTo(warnings, "photographs with a different exposure");
  if (const double spread = ExposureSpread(stops_of); !tracks.empty() && spread > kExposureSpread) {
    warnings->push_back(fmt::format(
        "the exposures of the photographs differ (brightness by {:.0f} %): --refine_cameras=pose+exposure fits them",
        100 * spread));
  }
  saturated.AppendTo(warnings, "photographs with many saturated pixels");
}

}  // namespace

ViewDiagnostics DiagnosticsOf(const gs::Image& image) {
  VESTA_CHECK(!image.empty(), "diagnostics need an image with pixels");
  gs::Image resized;
  if (image.width > kMaxWidth) {
    const auto height = std::lround(static_cast<double>(image.height) * kMaxWidth / image.width);
    resized = gs::ResizeArea(image, kMaxWidth, std::max(static_cast<int>(height), 1));
  }
  const gs::Image& seen = resized.empty() ? image : resized;
  const std::vector<double> luma = LumaOf(seen);
  const auto count = static_cast<double>(luma.size());
  ViewDiagnostics diagnostics;
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < luma.size(); ++i) {
    mean += luma[i] / count;
    square += luma[i] * luma[i] / count;
    diagnostics.saturated += IsSaturated(seen, i) ? 1 / count : 0;
  }
  const double variance = std::max(square - mean * mean, 0.0);
  diagnostics.contrast = std::sqrt(variance);
  constexpr double kLeastVariance = 1e-6;  // (a quarter of an 8-bit level)^2
  diagnostics.sharpness =
      variance > kLeastVariance ? MeanSquaredLaplacian(luma, seen.width, seen.height) / variance : 0;
  diagnostics.thumbnail = ThumbnailOf(image);
  return diagnostics;
}

double ThumbnailDistance(const ViewDiagnostics& a, const ViewDiagnostics& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.thumbnail.size(); ++i) {
    sum += static_cast<double>(std::abs(a.thumbnail[i] - b.thumbnail[i]));
  }
  return sum / static_cast<double>(a.thumbnail.size());
}

std::vector<std::string> SceneWarnings(const gs::Scene& scene, const gs::PointTracks& tracks) {
  std::vector<std::string> warnings;
  if (scene.views.empty()) return warnings;
  std::vector<ViewDiagnostics> diagnostics;
  diagnostics.reserve(scene.views.size());
  for (const gs::View& view : scene.views) diagnostics.push_back(DiagnosticsOf(*view.Photograph()));
  WarnOfNumbers(scene, &warnings);
  WarnOfSeen(scene, &warnings);
  WarnOfPoses(scene, &warnings);
  WarnOfDuplicates(scene, diagnostics, &warnings);
  WarnOfPhotographs(scene, tracks, diagnostics, &warnings);
  return warnings;
}

}  // namespace vesta::app
