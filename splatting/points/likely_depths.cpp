// SPDX-License-Identifier: Apache-2.0
#include "splatting/points/likely_depths.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace vesta::gs {
namespace {

using Vector = std::array<double, 3>;

// The point closest to the optical axes, by Cramer's rule; nullopt if they are nearly parallel.
std::optional<Vector> MeetingOfAxes(const std::vector<View>& views, const Vector& mean, double radius) {
  constexpr double kParallel = 1e-4;
  double a[3][3] = {}, b[3] = {};
  for (const View& view : views) {
    const Vector center = CameraCenter(view);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const double across =
            ((i == j ? 1 : 0) - view.rotation[6 + i] * view.rotation[6 + j]) / static_cast<double>(views.size());
        a[i][j] += across;
        b[i] += across * (center[j] - mean[j]) / radius;
      }
    }
  }
  const auto determinant = [](const double m[3][3]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  };
  const double whole = determinant(a);
  if (!(whole > kParallel)) return std::nullopt;
  Vector point;
  for (std::size_t j = 0; j < 3; ++j) {
    double replaced[3][3];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) replaced[i][k] = k == j ? b[i] : a[i][k];
    }
    point[j] = mean[j] + radius * determinant(replaced) / whole;
  }
  return point;
}

}  // namespace

std::vector<double> LikelyDepths(const std::vector<View>& views) {
  std::vector<const View*> all;
  all.reserve(views.size());
  for (const View& view : views) all.push_back(&view);
  const CameraSpread spread = SpreadOf(all);
  const double radius = spread.radius;
  constexpr double kRadiiAway = 4;
  std::vector<double> depths(views.size(), radius > 0 ? kRadiiAway * radius : 1.0);
  if (!(radius > 0)) return depths;
  const std::optional<Vector> meeting = MeetingOfAxes(views, spread.mean, radius);
  if (!meeting) return depths;
  std::vector<double> met;
  met.reserve(views.size());
  for (const View& view : views) met.push_back(InCamera(view, *meeting)[2]);
  constexpr double kLeastRadii = 0.1;
  const auto is_ahead = [&](double depth) { return depth > kLeastRadii * radius; };
  return std::ranges::all_of(met, is_ahead) ? met : depths;
}

}  // namespace vesta::gs
