#include "apps/doctor/view_signs.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"

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

}  // namespace vesta::app
