// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/scene/undistort.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

// Catmull-Rom weights of four pixels, for a position t in 0..1 beyond the second.
std::array<float, 4> CubicWeights(float t) {
  return {0.5f * t * ((2 - t) * t - 1), 0.5f * (t * t * (3 * t - 5) + 2), 0.5f * t * ((4 - 3 * t) * t + 1),
          0.5f * t * t * (t - 1)};
}

// Columns (or rows) around a position, and their weights. The border pixel is repeated beyond the border.
struct Neighbors {
  std::array<std::size_t, 4> index;
  std::array<float, 4> weight;
  bool are_inside;  // all four are in the image, so they are consecutive

  Neighbors(double place, int count) {
    // Positions farther out give the same result; the clamp prevents overflow of int.
    const double at = std::clamp(place - 0.5, -3.0, count + 2.0);
    const int first = static_cast<int>(at + 3) - 3;  // rounds down
    weight = CubicWeights(static_cast<float>(at - first));
    are_inside = first >= 1 && first + 2 < count;
    for (int k = 0; k < 4; ++k) {
      const int neighbor = first - 1 + k;
      index[static_cast<std::size_t>(k)] =
          static_cast<std::size_t>(are_inside ? neighbor : std::clamp(neighbor, 0, count - 1));
    }
  }
};

}  // namespace

std::array<float, 4> SampleCubic(const Image& image, double u, double v) {
  std::array<float, 4> result{};
  const Neighbors columns(u, image.width), rows(v, image.height);
  const std::size_t planes = image.transparency.empty() ? 3 : 4;
  for (std::size_t c = 0; c < planes; ++c) {
    const float* plane = c < 3 ? image.plane(static_cast<int>(c)) : image.transparency.data();
    // Columns first, so that four columns are processed at a time.
    std::array<float, 4> down{};
    for (std::size_t j = 0; j < 4; ++j) {
      const float* row = plane + rows.index[j] * static_cast<std::size_t>(image.width);
      if (columns.are_inside) {
        const float* from = row + columns.index[0];
        for (std::size_t i = 0; i < 4; ++i) down[i] += rows.weight[j] * from[i];
      } else {
        for (std::size_t i = 0; i < 4; ++i) down[i] += rows.weight[j] * row[columns.index[i]];
      }
    }
    float color = 0;
    for (std::size_t i = 0; i < 4; ++i) color += columns.weight[i] * down[i];
    result[c] = color;
  }
  return result;
}

bool IsUnmaskedAround(const Image& image, double u, double v) {
  if (!(u >= 0 && u <= image.width && v >= 0 && v <= image.height)) return false;
  if (image.mask.empty()) return true;
  const Neighbors columns(u, image.width), rows(v, image.height);
  for (const std::size_t j : {1u, 2u}) {
    for (const std::size_t i : {1u, 2u}) {
      if (image.mask[rows.index[j] * static_cast<std::size_t>(image.width) + columns.index[i]] == 0) return false;
    }
  }
  return true;
}

namespace {

using Point = std::array<double, 2>;

double Determinant(const std::array<double, 4>& j) { return j[0] * j[3] - j[1] * j[2]; }

// Largest distance from the axis, at focal length 1, where the lens is still one-to-one in all directions; at most
// tan(kWidest).
double InjectiveRadius(const Distortion& lens) {
  constexpr int kSteps = 512, kDirections = 32;
  constexpr double kWidest = 1.5;  // radians from the axis; a pinhole image cannot reach 90 degrees
  double radius = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double next = std::tan(kWidest * i / kSteps);
    for (int d = 0; d < kDirections; ++d) {
      const double direction = 2 * std::numbers::pi * d / kDirections;
      const std::array<double, 4> j = DistortionJacobian(lens, next * std::cos(direction), next * std::sin(direction));
      // A lens that folds twice has a positive determinant again, but not a positive trace.
      if (!(Determinant(j) > 0 && j[0] + j[3] > 0)) return radius;
    }
    radius = next;
  }
  return radius;
}

// A rectangle around the axis, at focal length 1: its extent to the left, right, up and down.
using Sides = std::array<double, 4>;

// The region of that plane that a photograph covers.
class SeenPlane {
 public:
  SeenPlane(const Camera& camera, const Distortion& lens)
      : camera_(camera), lens_(lens), radius_(InjectiveRadius(lens)) {}

  // slack: pixels beyond the centres of the outermost pixels that count as covered.
  bool Sees(double x, double y, double slack) const {
    if (!(std::hypot(x, y) <= radius_)) return false;
    const Point at = Distort(lens_, x, y);
    const double u = camera_.lens.fx * at[0] + camera_.lens.cx, v = camera_.lens.fy * at[1] + camera_.lens.cy;
    // Between the centres of the outermost pixels, interpolation has all its neighbours.
    const double margin = 0.5 - slack;
    return u >= margin && u <= camera_.width - margin && v >= margin && v <= camera_.height - margin;
  }
  // The border suffices, because the covered region has no holes.
  bool Sees(const Sides& s, double slack) const {
    constexpr int kSamples = 256;  // per side
    for (int i = 0; i <= kSamples; ++i) {
      const double part = static_cast<double>(i) / kSamples;
      const double x = -s[0] + part * (s[0] + s[1]), y = -s[2] + part * (s[2] + s[3]);
      if (!Sees(x, -s[2], slack) || !Sees(x, s[3], slack) || !Sees(-s[0], y, slack) || !Sees(s[1], y, slack)) {
        return false;
      }
    }
    return true;
  }

 private:
  const Camera& camera_;
  const Distortion& lens_;
  double radius_;
};

// Largest fraction in 0..1 for which `holds` is true, as for all smaller ones; 0 if none.
template <class Holds>
double LargestPart(const Holds& holds) {
  if (holds(1.0)) return 1;
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

// First the largest rectangle in the shape of the photograph; then extends each side in turn.
Sides LargestSeen(const SeenPlane& plane, const Sides& widest) {
  const auto scaled = [&](double part) {
    Sides sides = widest;
    for (double& side : sides) side *= part;
    return sides;
  };
  Sides sides = scaled(LargestPart([&](double part) { return plane.Sees(scaled(part), 0); }));
  // A side may touch the border between two samples; other samples then seem to reach beyond it.
  constexpr double kSlack = 0.02;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const double least = sides[i];
    const auto grown = [&](double part) {
      Sides wider = sides;
      wider[i] = least + part * (widest[i] - least);
      return wider;
    };
    sides = grown(LargestPart([&](double part) { return plane.Sees(grown(part), kSlack); }));
  }
  return sides;
}

}  // namespace

std::optional<Camera> PinholeOf(const Camera& camera, const Distortion& lens) {
  if (lens.is_none()) return camera;
  if (!lens.is_finite()) return std::nullopt;
  constexpr double kMost = 2, kLeast = 0.2;  // fractions of the photograph's width and height
  const splat::Lens& f = camera.lens;
  Sides widest{f.cx / f.fx, (camera.width - f.cx) / f.fx, f.cy / f.fy, (camera.height - f.cy) / f.fy};
  for (double& side : widest) {
    if (!(side > 0)) return std::nullopt;  // the photograph does not contain the optical axis
    side *= kMost;
  }
  const Sides sides = LargestSeen(SeenPlane(camera, lens), widest);
  // The region ends at the centres of the outermost pixels, within the rounding of the search.
  constexpr double kRounding = 1e-6;
  const double width = std::floor((sides[0] + sides[1]) * f.fx + 1 + kRounding);
  const double height = std::floor((sides[2] + sides[3]) * f.fy + 1 + kRounding);
  if (!(width >= std::max(1.0, kLeast * camera.width) && height >= std::max(1.0, kLeast * camera.height))) {
    return std::nullopt;
  }
  return Camera{static_cast<int>(width),
                static_cast<int>(height),
                {.fx = f.fx, .fy = f.fy, .cx = sides[0] * f.fx + 0.5, .cy = sides[2] * f.fy + 0.5}};
}

Image UndistortImage(const Image& image, const Camera& camera, const Distortion& lens, const Camera& pinhole) {
  VESTA_CHECK(image.width == camera.width && image.height == camera.height,
              "an image of {} x {} does not match a camera of {} x {}", image.width, image.height, camera.width,
              camera.height);
  constexpr int kMostSamples = 8;  // per pixel and direction
  Image result(pinhole.width, pinhole.height);
  if (!image.mask.empty()) result.mask.assign(result.num_pixels(), 1);
  if (!image.transparency.empty()) result.transparency.resize(result.num_pixels());
  const splat::Lens &from = camera.lens, &to = pinhole.lens;
  ParallelFor(pinhole.height, 8, [&](Index row) {
    for (int column = 0; column < pinhole.width; ++column) {
      const double x = (column + 0.5 - to.cx) / to.fx, y = (static_cast<double>(row) + 0.5 - to.cy) / to.fy;
      const std::array<double, 4> j = DistortionJacobian(lens, x, y);
      // Width or height of one result pixel, in photograph pixels.
      const double reach = std::max(std::hypot(j[0] * from.fx / to.fx, j[2] * from.fy / to.fx),
                                    std::hypot(j[1] * from.fx / to.fy, j[3] * from.fy / to.fy));
      // A lens that hardly shrinks the image needs no antialiasing and stays sharp.
      constexpr double kHardly = 1.25;
      const int samples = reach <= kHardly ? 1 : static_cast<int>(std::ceil(std::min<double>(reach, kMostSamples)));
      std::array<float, 4> sum{};
      bool counts = true;
      for (int b = 0; b < samples; ++b) {
        for (int a = 0; a < samples; ++a) {
          const double across = (a + 0.5) / samples - 0.5, down = (b + 0.5) / samples - 0.5;
          const Point at = Distort(lens, x + across / to.fx, y + down / to.fy);
          const double u = from.fx * at[0] + from.cx, v = from.fy * at[1] + from.cy;
          const std::array<float, 4> color = SampleCubic(image, u, v);
          counts = counts && IsUnmaskedAround(image, u, v);
          for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += color[c];
        }
      }
      const std::size_t pixel =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(pinhole.width) + static_cast<std::size_t>(column);
      if (!counts && !result.mask.empty()) result.mask[pixel] = 0;
      const float share = 1.0f / static_cast<float>(samples * samples);
      const auto mean = [&](std::size_t c) { return std::clamp(share * sum[c], 0.0f, 1.0f); };
      for (std::size_t c = 0; c < 3; ++c) result.plane(static_cast<int>(c))[pixel] = mean(c);
      if (!result.transparency.empty()) result.transparency[pixel] = mean(3);
    }
  });
  return result;
}

}  // namespace vesta::gs
