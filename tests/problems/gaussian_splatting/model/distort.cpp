// SPDX-License-Identifier: Apache-2.0
#include "tests/problems/gaussian_splatting/model/distort.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/scene/undistort.h"

namespace vesta::gs::test {
namespace {

// Where the pinhole's image has the point that the camera shows at (u, v).
std::optional<std::array<double, 2>> PinholePixel(const Camera& pinhole, const Camera& camera, const Distortion& lens,
                                                  double u, double v) {
  const splat::Lens &from = camera.lens, &to = pinhole.lens;
  const auto at = Undistort(lens, (u - from.cx) / from.fx, (v - from.cy) / from.fy);
  if (!at) return std::nullopt;
  return std::array{to.fx * (*at)[0] + to.cx, to.fy * (*at)[1] + to.cy};
}

bool SeesAll(const Camera& pinhole, const Camera& camera, const Distortion& lens) {
  const auto sees = [&](double u, double v) {
    const auto at = PinholePixel(pinhole, camera, lens, u, v);
    return at && (*at)[0] >= 0.5 && (*at)[0] <= pinhole.width - 0.5 && (*at)[1] >= 0.5 &&
           (*at)[1] <= pinhole.height - 0.5;
  };
  for (int i = 0; i < camera.width; ++i) {
    if (!sees(i + 0.5, 0.5) || !sees(i + 0.5, camera.height - 0.5)) return false;
  }
  for (int j = 0; j < camera.height; ++j) {
    if (!sees(0.5, j + 0.5) || !sees(camera.width - 0.5, j + 0.5)) return false;
  }
  return true;
}

}  // namespace

std::optional<std::array<double, 2>> Undistort(const Distortion& lens, double x, double y) {
  constexpr int kSteps = 16, kNewton = 20;
  constexpr double kDone = 1e-14, kConverged = 1e-9;
  const double scale = std::max(1.0, std::hypot(x, y));
  std::array<double, 2> at{0, 0};
  for (int step = 1; step <= kSteps; ++step) {
    double gap = 0;
    for (int i = 0; i < kNewton; ++i) {
      const std::array<double, 2> seen = Distort(lens, at[0], at[1]);
      const double gap_x = x * step / kSteps - seen[0], gap_y = y * step / kSteps - seen[1];
      gap = std::hypot(gap_x, gap_y);
      if (!(gap > kDone * scale)) break;
      const std::array<double, 4> j = DistortionJacobian(lens, at[0], at[1]);
      const double determinant = j[0] * j[3] - j[1] * j[2];
      if (!(determinant > 0)) return std::nullopt;
      at[0] += (j[3] * gap_x - j[1] * gap_y) / determinant;
      at[1] += (j[0] * gap_y - j[2] * gap_x) / determinant;
    }
    if (!(gap < kConverged * scale)) return std::nullopt;
  }
  return at;
}

Camera DistortedCamera(const Camera& pinhole, const Distortion& lens) {
  const splat::Lens& f = pinhole.lens;
  for (int percent = 200; percent > 0; --percent) {
    const double part = 0.01 * percent;
    const Camera camera{static_cast<int>(part * pinhole.width),
                        static_cast<int>(part * pinhole.height),
                        {.fx = f.fx, .fy = f.fy, .cx = part * f.cx, .cy = part * f.cy}};
    if (camera.width > 0 && camera.height > 0 && SeesAll(pinhole, camera, lens)) return camera;
  }
  Fail(kBadArgument, "the lens sees no part of the pinhole's image; use smaller coefficients");
}

Image DistortImage(const Image& image, const Camera& pinhole, const Camera& camera, const Distortion& lens) {
  Image result(camera.width, camera.height);
  ParallelFor(camera.height, 8, [&](Index row) {
    for (int column = 0; column < camera.width; ++column) {
      const auto at = PinholePixel(pinhole, camera, lens, column + 0.5, static_cast<double>(row) + 0.5);
      if (!at) continue;
      const std::array<float, 4> color = SampleCubic(image, (*at)[0], (*at)[1]);
      const std::size_t pixel =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(column);
      for (int c = 0; c < 3; ++c) {
        result.plane(c)[pixel] = std::clamp(color[static_cast<std::size_t>(c)], 0.0f, 1.0f);
      }
    }
  });
  return result;
}

}  // namespace vesta::gs::test
