// SPDX-License-Identifier: Apache-2.0
#include "apps/doctor/view_signs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/lenses/models.h"
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

bool IsBurnt(const gs::Image& image, std::size_t pixel) {
  constexpr int kTop = 254;
  const auto is_at_top = [&](int c) { return gs::QuantizeColor(image.plane(c)[pixel]) >= kTop; };
  return is_at_top(0) || is_at_top(1) || is_at_top(2);
}

// Of any size: what is smaller than the thumbnail repeats its pixels.
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

}  // namespace

ViewSigns SignsOf(const gs::Image& image) {
  VESTA_CHECK(!image.empty(), "an image without pixels has no signs");
  gs::Image resized;
  if (image.width > kMaxWidth) {
    const auto height = std::lround(static_cast<double>(image.height) * kMaxWidth / image.width);
    resized = gs::ResizeArea(image, kMaxWidth, std::max(static_cast<int>(height), 1));
  }
  const gs::Image& seen = resized.empty() ? image : resized;
  const std::vector<double> luma = LumaOf(seen);
  const auto count = static_cast<double>(luma.size());
  ViewSigns signs;
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < luma.size(); ++i) {
    mean += luma[i] / count;
    square += luma[i] * luma[i] / count;
    signs.burnt += IsBurnt(seen, i) ? 1 / count : 0;
  }
  const double variance = std::max(square - mean * mean, 0.0);
  signs.contrast = std::sqrt(variance);
  constexpr double kLeastVariance = 1e-6;  // a quarter of a level of 8 bits, squared
  signs.sharpness = variance > kLeastVariance ? MeanSquaredLaplacian(luma, seen.width, seen.height) / variance : 0;
  signs.thumbnail = ThumbnailOf(image);
  return signs;
}

double ThumbnailDistance(const ViewSigns& a, const ViewSigns& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.thumbnail.size(); ++i) {
    sum += static_cast<double>(std::abs(a.thumbnail[i] - b.thumbnail[i]));
  }
  return sum / static_cast<double>(a.thumbnail.size());
}

namespace {

constexpr Index kSample = 5000;      // of the points
constexpr std::size_t kFewest = 20;  // that tell anything

// log2 of the light of a colour, 0..1; NaN where it is too dark or too light to tell.
double Stops(double red, double green, double blue) {
  const double luma = Luma(red, green, blue);
  return luma > 0.04 && luma < 0.98 ? 2.2 * std::log2(luma) : std::numeric_limits<double>::quiet_NaN();
}

// The pixel that shows the point, which lies in the image.
std::size_t PixelOf(const gs::View& view, const std::array<float, 3>& point) {
  const auto t =
      gs::InCamera(view, {static_cast<double>(point[0]), static_cast<double>(point[1]), static_cast<double>(point[2])});
  double u = 0, v = 0;
  splat::PixelOf(view.camera.lens, t.data(), u, v);
  const int x = std::clamp(static_cast<int>(u), 0, view.camera.width - 1);
  const int y = std::clamp(static_cast<int>(v), 0, view.camera.height - 1);
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(view.camera.width) + static_cast<std::size_t>(x);
}

// Quartiles of the differences of its points; NaN where they are too few.
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

std::vector<double> ExposureStops(const gs::Scene& scene) {
  std::vector<Quartiles> quartiles;
  std::vector<double> known;
  for (const gs::View& view : scene.views) {
    quartiles.push_back(DifferencesOf(view, scene.points));
    if (std::isfinite(quartiles.back().middle)) known.push_back(quartiles.back().middle);
  }
  const double usual = known.empty() ? 0 : gs::Median(std::move(known));
  std::vector<double> stops;
  stops.reserve(quartiles.size());
  for (const Quartiles& of : quartiles) {
    const bool agrees = !((of.low - usual) * (of.high - usual) <= 0);
    stops.push_back(agrees ? of.middle - usual : 0);
  }
  return stops;
}

}  // namespace vesta::app
