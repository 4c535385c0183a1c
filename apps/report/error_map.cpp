#include "apps/report/error_map.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "apps/report/heat_color.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::app {
namespace {

constexpr int kLevels = 255;

constexpr std::int64_t kGrain = 1 << 14;

// Calls take(pixel, differences of the channels in levels of 8 bits), on all threads.
template <class Take>
void ForEachDifference(const gs::Image& render, const gs::Image& truth, const Take& take) {
  VESTA_CHECK(render.width == truth.width && render.height == truth.height && !render.empty() && !truth.empty(),
              "images of {} x {} and {} x {}", render.width, render.height, truth.width, truth.height);
  ParallelFor(static_cast<std::int64_t>(render.num_pixels()), kGrain, [&](std::int64_t i) {
    std::array<int, 3> difference;
    for (int c = 0; c < 3; ++c) {
      difference[static_cast<std::size_t>(c)] =
          gs::QuantizeColor(render.plane(c)[i]) - gs::QuantizeColor(truth.plane(c)[i]);
    }
    take(static_cast<std::size_t>(i), difference);
  });
}

}  // namespace

gs::Image ErrorMap(const gs::Image& render, const gs::Image& truth) {
  gs::Image map(render.width, render.height);
  constexpr auto kBrightest = static_cast<float>(3 * kLevels * kBrightestError);
  ForEachDifference(render, truth, [&](std::size_t pixel, const std::array<int, 3>& difference) {
    const int sum = std::abs(difference[0]) + std::abs(difference[1]) + std::abs(difference[2]);
    const std::array<float, 3> color = HeatColor(std::min(static_cast<float>(sum) / kBrightest, 1.0f));
    for (int c = 0; c < 3; ++c) map.plane(c)[pixel] = color[static_cast<std::size_t>(c)];
  });
  return map;
}

double PartWithHalfOfError(const gs::Image& render, const gs::Image& truth) {
  std::vector<std::uint32_t> errors(render.num_pixels());
  ForEachDifference(render, truth, [&](std::size_t pixel, const std::array<int, 3>& d) {
    errors[pixel] = static_cast<std::uint32_t>(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  });
  std::vector<std::uint32_t> pixels_with(3 * kLevels * kLevels + 1);  // by their squared error
  double all = 0;
  for (const std::uint32_t squared : errors) {
    ++pixels_with[squared];
    all += squared;
  }
  double error = 0, pixels = 0;
  for (std::size_t squared = pixels_with.size() - 1; squared > 0 && error < all / 2; --squared) {
    const double fitting = std::min<double>(pixels_with[squared], (all / 2 - error) / static_cast<double>(squared));
    error += fitting * static_cast<double>(squared);
    pixels += fitting;
  }
  return pixels / static_cast<double>(render.num_pixels());
}

}  // namespace vesta::app
