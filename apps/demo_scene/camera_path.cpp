#include "apps/demo_scene/camera_path.h"

#include <numbers>

namespace vesta::demo {
namespace {

View LookAt(const Vec3& position, const Vec3& target) {
  const Vec3 forward = Normalized(target - position);
  const Vec3 right = Normalized(Cross({0, 1, 0}, forward));
  View view;
  view.cam_from_world = {{right, Cross(forward, right), forward}};
  view.position = position;
  return view;
}

}  // namespace

std::vector<View> CameraPath(int count, int width, int height) {
  constexpr double kHalfFieldOfView = 29.0 * std::numbers::pi / 180;  // horizontal
  const Vec3 target{0, -0.42, 0};
  std::vector<View> views;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    const bool high = (k + k / 8) % 2 != 0;
    const double radius = high ? 2.75 : 3.15, eye = high ? 1.95 : 1.0;
    View view = LookAt({radius * std::cos(angle), -eye, radius * std::sin(angle)}, target);
    view.width = width;
    view.height = height;
    view.focal = 0.5 * width / std::tan(kHalfFieldOfView);
    views.push_back(view);
  }
  return views;
}

}  // namespace vesta::demo
