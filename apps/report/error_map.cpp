// SPDX-License-Identifier: Apache-2.0
#include "apps/report/error_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "apps/inputs/posed_model.h"
#include "apps/report/html.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "splatting/io/images/image_file.h"

namespace vesta::app {
namespace {

// Of matplotlib's inferno, which the page's scale shows too.
constexpr std::array<std::array<float, 3>, 6> kColors = {{{0.000f, 0.000f, 0.016f},
                                                          {0.259f, 0.039f, 0.408f},
                                                          {0.576f, 0.149f, 0.404f},
                                                          {0.867f, 0.318f, 0.227f},
                                                          {0.988f, 0.647f, 0.039f},
                                                          {0.988f, 1.000f, 0.643f}}};

}  // namespace

std::array<float, 3> HeatColor(float of) { return gs::OnScale(kColors, of); }

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

namespace {

std::string Jpeg(const gs::Image& image, int max_width) {
  constexpr int kQuality = 85;
  const int width = std::min(image.width, max_width);
  const auto height = static_cast<int>(std::lround(static_cast<double>(image.height) * width / image.width));
  return DataUri(
      "image/jpeg",
      gs::EncodeJpeg(width == image.width ? image : gs::ResizeArea(image, width, std::max(height, 1)), kQuality));
}

}  // namespace

ViewRenderer::ViewRenderer(const gs::SplatModel& model, const gs::Scene& scene)
    : model_(model), scene_(scene), renderer_(ToDouble(model.background), gs::NearPlane(scene)) {}

std::vector<ViewError> ViewRenderer::Measure() {
  std::vector<ViewError> errors;
  ImageQualityMeter meter;
  for (const gs::View& view : scene_.views) {
    if (!view.is_test()) continue;
    const std::shared_ptr<const gs::Image> photograph = view.Photograph();
    const gs::Image render = gs::ToCompare(renderer_.Render(model_, view), *photograph);
    const ImageQuality whole =
        meter.Measure(gs::ValuesOf(render), gs::ValuesOf(*photograph), {view.camera.width, view.camera.height});
    const gs::ViewQuality of_counted = gs::QualityOf(0, *photograph, whole, 0);
    errors.push_back({view.name, of_counted.quality, PartWithHalfOfError(render, *photograph) / of_counted.counted});
  }
  return errors;
}

ViewPictures ViewRenderer::Picture(const gs::View& view, int max_width) {
  const std::shared_ptr<const gs::Image> photograph = view.Photograph();
  const gs::Image render = renderer_.Render(model_, view);
  return {.width = view.camera.width,
          .height = view.camera.height,
          .truth = Jpeg(*photograph, max_width),
          .render = Jpeg(render, max_width),
          .error = Jpeg(ErrorMap(gs::ToCompare(render, *photograph), *photograph),
                        (std::min(max_width, render.width) + 1) / 2)};
}

}  // namespace vesta::app
