// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/scene_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {
namespace {

using Json = nlohmann::json;
using Point = std::array<double, 3>;

struct Place {
  Point middle{};
  double radius = 1;
};

// point(i): of `count`. Of many some suffice.
template <class PointAt>
Place PlaceOf(Index count, const PointAt& point) {
  constexpr Index kEnough = 20000;
  Place place;
  if (count == 0) return place;
  const Index step = std::max<Index>(1, count / kEnough);
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (Index i = 0; i < count; i += step) values.push_back(point(i)[k]);
    place.middle[k] = gs::Median(std::move(values));
  }
  std::vector<double> distances;
  for (Index i = 0; i < count; i += step) {
    const Point p = point(i);
    distances.push_back(std::hypot(p[0] - place.middle[0], p[1] - place.middle[1], p[2] - place.middle[2]));
  }
  const double radius = gs::Median(std::move(distances));
  if (radius > 0) place.radius = radius;
  return place;
}

Place PlaceOf(const gs::SplatModel& model) {
  return PlaceOf(model.count, [&](Index i) {
    Point point;
    for (int k = 0; k < 3; ++k) point[static_cast<std::size_t>(k)] = static_cast<double>(model.Value(k, i));
    return point;
  });
}

Place PlaceOf(const gs::PointCloud& points) {
  return PlaceOf(points.size(), [&](Index i) {
    const auto& p = points.positions[static_cast<std::size_t>(i)];
    return Point{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  });
}

// Against the mean of the cameras' downward axes; without cameras that of a camera that turns nothing.
Point UpOf(const gs::Scene& scene) {
  Point up = gs::SumOfUps(scene.views);
  const double length = std::hypot(up[0], up[1], up[2]);
  if (length < 1e-6 * static_cast<double>(scene.views.size()) || length == 0) return {0, -1, 0};
  for (double& x : up) x /= length;
  return up;
}

const char* RoleName(gs::ViewRole role) {
  switch (role) {
    case gs::ViewRole::kTraining:
      return "train";
    case gs::ViewRole::kHeldOut:
      return "held_out";
    case gs::ViewRole::kTest:
      return "test";
  }
  return "?";
}

Json ViewJson(const gs::View& view) {
  double to_camera[4];
  std::array<double, 4> to_world;
  QuaternionFromRotation(view.rotation.data(), to_camera);
  QuaternionConjugate(to_camera, to_world.data());
  return {{"name", view.name},
          {"role", RoleName(view.role)},
          {"width", view.camera.width},
          {"height", view.camera.height},
          {"position", gs::CameraCenter(view)},
          {"rotation", to_world},
          {"focal", view.camera.lens.fy / view.camera.height}};
}

}  // namespace

double ExtentOf(const gs::SplatModel& model) { return PlaceOf(model).radius; }

std::string SceneJson(const gs::Scene& scene, const std::vector<gs::View>& views, const gs::SplatModel& model) {
  const Place place = scene.points.size() > 0 ? PlaceOf(scene.points) : PlaceOf(model);
  Json cameras = Json::array();
  for (const gs::View& view : views) cameras.push_back(ViewJson(view));
  const Json json = {{"pivot", place.middle}, {"radius", place.radius}, {"up", UpOf(scene)}, {"views", cameras}};
  // A view's name need not be UTF-8.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace vesta::app
