// SPDX-License-Identifier: Apache-2.0
#include "apps/report/error_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "apps/cli/print.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/report/html.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/images/image_file.h"

namespace vesta::app {
namespace {

// From matplotlib's inferno, as in the legend of the page.
constexpr std::array<std::array<float, 3>, 6> kColors = {{{0.000f, 0.000f, 0.016f},
                                                          {0.259f, 0.039f, 0.408f},
                                                          {0.576f, 0.149f, 0.404f},
                                                          {0.867f, 0.318f, 0.227f},
                                                          {0.988f, 0.647f, 0.039f},
                                                          {0.988f, 1.000f, 0.643f}}};

constexpr int kLevels = 255;

constexpr std::int64_t kGrain = 1 << 14;

// Calls take(pixel, channel differences in 8-bit levels) for all pixels, on all threads.
template <class Take>
void ForEachDifference(const gs::Image& render, const gs::Image& truth, const Take& take) {
  VESTA_CHECK(render.width == truth.width && render.height == truth.height && !render.empty() && !truth.empty(),
              "images of different sizes: {} x {} and {} x {}", render.width, render.height, truth.width, truth.height);
  ParallelFor(static_cast<std::int64_t>(render.num_pixels()), kGrain, [&](std::int64_t i) {
    std::array<int, 3> difference;
    for (int c = 0; c < 3; ++c) {
      difference[static_cast<std::size_t>(c)] =
          gs::QuantizeColor(render.plane(c)[i]) - gs::QuantizeColor(truth.plane(c)[i]);
    }
    take(static_cast<std::size_t>(i), difference);
  });
}

std::string Jpeg(const gs::Image& image, int max_width) {
  constexpr int kQuality = 85;
  const int width = std::min(image.width, max_width);
  const auto height = static_cast<int>(std::lround(static_cast<double>(image.height) * width / image.width));
  return DataUri(
      "image/jpeg",
      gs::EncodeJpeg(width == image.width ? image : gs::ResizeArea(image, width, std::max(height, 1)), kQuality));
}

using Vec3 = std::array<double, 3>;
constexpr double kSize = 460, kMargin = 18;  // pixels

double Dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 Unit(const Vec3& a, const Vec3& otherwise) {
  const double length = std::sqrt(Dot(a, a));
  return length > 1e-9 ? Vec3{a[0] / length, a[1] / length, a[2] / length} : otherwise;
}
// An axis of the camera (x right, y down, z forward) in world coordinates.
Vec3 Axis(const gs::View& view, std::size_t axis) {
  return {view.rotation[3 * axis], view.rotation[3 * axis + 1], view.rotation[3 * axis + 2]};
}

struct Axes {
  Vec3 right, forward, up;
};

Axes AxesOf(const gs::Scene& scene) {
  const Vec3 up = Unit(gs::SumOfUps(scene.views), {0, 0, 1});
  // Perpendicular to up and to the viewing direction of the first camera; to its y axis if it looks straight down.
  const gs::View& first = scene.views.front();
  const Vec3 right = Unit(Cross(Axis(first, 2), up), Unit(Cross(Axis(first, 1), up), {1, 0, 0}));
  return {right, Cross(up, right), up};
}

// A drawing plane, and the range of the points to show.
class Drawing {
 public:
  Drawing(const Vec3& across, const Vec3& along) : across_(across), along_(along) {}

  std::array<double, 2> InPlane(const Vec3& point) const { return {Dot(point, across_), Dot(point, along_)}; }
  void Show(const Vec3& point) {
    const auto at = InPlane(point);
    for (std::size_t i = 0; i < 2; ++i) {
      low_[i] = std::min(low_[i], at[i]);
      high_[i] = std::max(high_[i], at[i]);
    }
  }
  double extent() const { return std::max({high_[0] - low_[0], high_[1] - low_[1], 1e-12}); }
  // Pixel position; both axes have the same scale.
  std::array<double, 2> At(const Vec3& point) const {
    const double scale = (kSize - 2 * kMargin) / extent();
    const auto at = InPlane(point);
    return {kSize / 2 + scale * (at[0] - (low_[0] + high_[0]) / 2),
            kSize / 2 - scale * (at[1] - (low_[1] + high_[1]) / 2)};
  }

 private:
  Vec3 across_, along_;
  std::array<double, 2> low_{INFINITY, INFINITY}, high_{-INFINITY, -INFINITY};
};

// Several hundred points without the outermost ones, often outliers.
std::vector<Vec3> SampleOf(const gs::PointCloud& points, const Axes& axes) {
  constexpr Index kMost = 900;
  constexpr double kOutermost = 0.03;
  const Index stride = std::max<Index>(1, points.size() / kMost);
  std::vector<Vec3> sample;
  for (Index i = 0; i < points.size(); i += stride) {
    const auto& point = points.positions[static_cast<std::size_t>(i)];
    sample.push_back({static_cast<double>(point[0]), static_cast<double>(point[1]), static_cast<double>(point[2])});
  }
  for (const Vec3& axis : {axes.right, axes.forward, axes.up}) {
    const auto before = [&](const Vec3& a, const Vec3& b) { return Dot(a, axis) < Dot(b, axis); };
    std::sort(sample.begin(), sample.end(), before);
    const auto cut = static_cast<std::ptrdiff_t>(kOutermost * static_cast<double>(sample.size()));
    sample = {sample.begin() + cut, sample.end() - cut};
  }
  return sample;
}

// A wedge that opens in the viewing direction.
std::string Camera(const Drawing& drawing, const gs::View& view) {
  const Vec3 center = gs::CameraCenter(view), right = Axis(view, 0), forward = Axis(view, 2);
  const double length = 0.05 * drawing.extent();
  const auto corner = [&](double side) {
    Vec3 at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = center[i] + length * (forward[i] + 0.45 * side * right[i]);
    return drawing.At(at);
  };
  const auto tip = drawing.At(center), left = corner(-1), other = corner(1);
  return fmt::format(
      R"(<path d="M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}Z"/><circle cx="{:.1f}" cy="{:.1f}" r="2.6"/>)", tip[0],
      tip[1], left[0], left[1], other[0], other[1], tip[0], tip[1]);
}

// From red (worst view) to green (best view).
std::string ColorOf(double psnr, std::span<const ViewError> errors) {
  double worst = INFINITY, best = -INFINITY;
  for (const ViewError& error : errors) {
    if (!std::isfinite(error.quality.psnr)) continue;
    worst = std::min(worst, error.quality.psnr);
    best = std::max(best, error.quality.psnr);
  }
  const double part = best > worst && std::isfinite(psnr) ? (psnr - worst) / (best - worst) : 1;
  return fmt::format("hsl({:.0f} 75% 45%)", 120 * part);
}

std::string Draw(const char* title, Drawing drawing, const gs::Scene& scene, const std::vector<Vec3>& points,
                 std::span<const ViewError> errors) {
  for (const gs::View& view : scene.views) drawing.Show(gs::CameraCenter(view));
  for (const Vec3& point : points) drawing.Show(point);
  std::string cloud, training, test;
  for (const Vec3& point : points) {
    const auto at = drawing.At(point);
    cloud += fmt::format("M{:.1f} {:.1f}h0", at[0], at[1]);
  }
  for (const gs::View& view : scene.views) {
    const auto error =
        std::find_if(errors.begin(), errors.end(), [&](const ViewError& e) { return e.name == view.name; });
    const bool is_known = view.is_test() && error != errors.end();
    const std::string name = Escape(view.name);
    const std::string label = is_known ? fmt::format("{}: {} dB", name, Figure(error->quality.psnr, 2)) : name;
    const std::string color =
        view.is_test()
            ? fmt::format(R"( style="color:{}")", is_known ? ColorOf(error->quality.psnr, errors) : "var(--run0)")
            : "";
    (view.is_test() ? test : training) +=
        fmt::format(R"(<g class="camera{}"{}><title>{}</title>{}</g>)", view.is_test() ? "" : " training", color, label,
                    Camera(drawing, view));
  }
  return fmt::format(
      R"(<svg viewBox="0 0 {0} {0}" role="img" aria-label="cameras {1}"><path class="cloud" d="{2}"/>{3}{4}<text class="title" x="12" y="20">{1}</text></svg>)"
      "\n",
      kSize, title, cloud, training, test);
}

}  // namespace

std::array<float, 3> HeatColor(float of) { return gs::OnScale(kColors, of); }

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

double FractionWithHalfOfError(const gs::Image& render, const gs::Image& truth) {
  std::vector<std::uint32_t> errors(render.num_pixels());
  ForEachDifference(render, truth, [&](std::size_t pixel, const std::array<int, 3>& d) {
    errors[pixel] = static_cast<std::uint32_t>(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  });
  std::vector<std::uint32_t> pixels_with(3 * kLevels * kLevels + 1);  // histogram over the squared error
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
    errors.push_back(
        {view.name, of_counted.quality, FractionWithHalfOfError(render, *photograph) / of_counted.counted});
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

std::string CameraPlans(const gs::Scene& scene, std::span<const ViewError> errors) {
  if (scene.views.empty()) return "";
  const Axes axes = AxesOf(scene);
  const std::vector<Vec3> points = SampleOf(scene.points, axes);
  return Draw("from above", Drawing(axes.right, axes.forward), scene, points, errors) +
         Draw("from the side", Drawing(axes.forward, axes.up), scene, points, errors);
}

}  // namespace vesta::app
