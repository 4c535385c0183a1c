// SPDX-License-Identifier: Apache-2.0
#include "demo/scene/camera_path.h"

#include <numbers>

namespace vesta::demo {
namespace {

View LookAt(const Vec3& position, const Vec3& target, int width, int height) {
  constexpr double kHalfFieldOfView = 29.0 * std::numbers::pi / 180;  // horizontal
  const Vec3 forward = Normalized(target - position);
  const Vec3 right = Normalized(Cross({0, 1, 0}, forward));
  View view;
  view.cam_from_world = {{right, Cross(forward, right), forward}};
  view.position = position;
  view.width = width;
  view.height = height;
  view.focal = 0.5 * width / std::tan(kHalfFieldOfView);
  return view;
}

// Point at this height above the floor, at this angle and distance from the scene's vertical axis.
Vec3 Around(double angle, double radius, double height) {
  return {radius * std::cos(angle), -height, radius * std::sin(angle)};
}

}  // namespace

std::vector<View> CameraPath(int count, int width, int height) {
  const Vec3 target{0, -0.42, 0};
  std::vector<View> views;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    const bool high = (k + k / 8) % 2 != 0;
    views.push_back(LookAt(Around(angle, high ? 2.75 : 3.15, high ? 1.95 : 1.0), target, width, height));
  }
  return views;
}

std::vector<View> Walk(int count, int width, int height) {
  std::vector<View> views;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    const Vec3 eye = Around(angle, 2.95 + 0.15 * std::sin(5 * angle), 1.45 + 0.45 * std::sin(3 * angle + 1));
    const Vec3 target{0.12 * std::sin(4 * angle), -0.42 + 0.06 * std::cos(7 * angle), 0.12 * std::cos(6 * angle)};
    views.push_back(LookAt(eye, target, width, height));
  }
  return views;
}

}  // namespace vesta::demo
