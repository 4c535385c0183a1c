// SPDX-License-Identifier: Apache-2.0
#include "demo/scene/bent_rays.h"

#include <charconv>
#include <cmath>
#include <vector>

#include "kernels/core/check.h"

namespace vesta::demo {

std::optional<std::array<double, 2>> Undistort(const gs::Distortion& lens, double u, double v) {
  if (lens.is_none()) return std::array{u, v};
  constexpr int kIterations = 30;
  constexpr double kTolerance = 1e-12;
  double x = u, y = v;
  for (int i = 0; i < kIterations; ++i) {
    const std::array<double, 2> at = gs::Distort(lens, x, y);
    const std::array<double, 4> j = gs::DistortionJacobian(lens, x, y);
    const double determinant = j[0] * j[3] - j[1] * j[2];
    if (!(determinant > 0 && j[0] + j[3] > 0)) return std::nullopt;  // beyond the fold of the lens
    const double du = u - at[0], dv = v - at[1];
    if (std::hypot(du, dv) < kTolerance) return std::array{x, y};
    x += (j[3] * du - j[1] * dv) / determinant;
    y += (j[0] * dv - j[2] * du) / determinant;
  }
  return std::nullopt;
}

gs::Distortion ParseLens(const std::string& text) {
  std::vector<double> numbers;
  const char *at = text.data(), *end = at + text.size();
  bool is_list = true;
  while (is_list && at != end) {
    const auto [next, error] = std::from_chars(at, end, numbers.emplace_back());
    is_list = error == std::errc{} && (next == end || (*next == ',' && next + 1 != end));
    at = next == end ? end : next + 1;
  }
  const std::size_t count = numbers.size();
  if (!is_list || count == 3 || count > 4)
    Fail(kBadArgument, "--lens={} is not a lens; give k1 or k1,k2 or k1,k2,p1,p2, as --lens=-0.1,0.02,0.001,-0.001",
         text);
  numbers.resize(4);
  const gs::Distortion lens{.radial = {numbers[0], numbers[1]}, .tangential = {numbers[2], numbers[3]}};
  if (!lens.is_finite()) Fail(kBadArgument, "--lens={} has a coefficient that is not finite; give finite ones", text);
  return lens;
}

}  // namespace vesta::demo
