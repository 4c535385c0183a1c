// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/scene_frame.h"

#include <algorithm>
#include <cmath>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {
namespace {

using Point = std::array<double, 3>;

double LargestOf(const Point& p) { return std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}); }

Point MiddleOf(const std::vector<Point>& points) {
  Point middle;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> values;
    values.reserve(points.size());
    for (const Point& point : points) values.push_back(point[k]);
    middle[k] = Median(std::move(values));
  }
  return middle;
}

double MedianDistance(const std::vector<Point>& points, const Point& from) {
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const Point& p : points) distances.push_back(LargestOf({p[0] - from[0], p[1] - from[1], p[2] - from[2]}));
  return Median(std::move(distances));
}

// The files' own origin, or a new one if the scene is far from it.
Point OriginOf(const std::vector<Point>& points, const std::vector<View>& views) {
  constexpr double kFar = 100;
  const Point middle = MiddleOf(points);
  double size = MedianDistance(points, middle);
  if (size == 0) {
    std::vector<Point> centers;
    centers.reserve(views.size());
    for (const View& view : views) centers.push_back(CameraCenter(view));
    size = MedianDistance(centers, middle);
  }
  if (!(size > 0 && LargestOf(middle) > kFar * size)) return {};
  // Rounds the origin to a number with few digits.
  const double step = std::exp2(std::floor(std::log2(size)));
  Point origin;
  for (std::size_t k = 0; k < 3; ++k) origin[k] = step * std::round(middle[k] / step) + 0.0;  // + 0.0 turns -0 into 0
  return origin;
}

bool FloatsHold(const Scene& scene) {
  constexpr double kMostExtents = 1000;
  return LargestOf(scene.origin) <= kMostExtents * scene.extent;
}

void Move(const Point& by, SplatModel* model) {
  for (int k = 0; k < 3; ++k) {
    const double shift = by[static_cast<std::size_t>(k)];
    if (shift == 0) continue;
    float* mean = model->attribute(splat::kMean + k);
    for (Index i = 0; i < model->count; ++i) mean[i] = static_cast<float>(static_cast<double>(mean[i]) + shift);
  }
}

// Moves the frame's origin to `by`, in the view's present frame.
void Move(const Point& by, View* view) {
  const auto& r = view->rotation;
  for (std::size_t i = 0; i < 3; ++i) {
    view->translation[i] += r[3 * i] * by[0] + r[3 * i + 1] * by[1] + r[3 * i + 2] * by[2];
  }
}

}  // namespace

void PlaceInScene(const WorldPoints& points, Scene* scene) {
  const Point origin = OriginOf(points.positions, scene->views);
  scene->origin = origin;
  if (origin != Point{}) {
    for (View& view : scene->views) Move(origin, &view);
  }
  scene->points.positions.reserve(points.positions.size());
  for (const Point& p : points.positions) {
    std::array<float, 3> position;
    for (std::size_t k = 0; k < 3; ++k) position[k] = static_cast<float>(p[k] - origin[k]);
    scene->points.positions.push_back(position);
  }
  scene->points.colors = points.colors;
  scene->extent = SceneExtent(scene->views, scene->points);
}

void MoveToScene(const Scene& scene, SplatModel* model) {
  const Point &from = model->origin, &to = scene.origin;
  Move({from[0] - to[0], from[1] - to[1], from[2] - to[2]}, model);
  model->origin = to;
}

void MoveToScene(const Scene& scene, View* view) { Move(scene.origin, view); }

void MoveToWorld(const Scene& scene, View* view) {
  const Point& origin = scene.origin;
  Move({-origin[0], -origin[1], -origin[2]}, view);
}

void MoveToWorld(const Scene& scene, SplatModel* model) {
  model->origin = scene.origin;
  if (!FloatsHold(scene)) return;
  Move(scene.origin, model);
  model->origin = {};
}

}  // namespace vesta::gs
