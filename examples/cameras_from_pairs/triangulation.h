// SPDX-License-Identifier: Apache-2.0
// Positions of points from known cameras.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "views.h"

// A ray of a view to a point, in world coordinates.
struct Ray {
  Vector3d origin, direction;
  double weight = 1;
};

// The point with the least weighted sum of squared distances to the lines of the rays.
inline Vector3d NearestPoint(const std::vector<Ray>& rays) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const auto& [origin, direction, weight] : rays) {
    const Eigen::Matrix3d across = weight * (Eigen::Matrix3d::Identity() - direction * direction.transpose());
    matrix += across;
    right += across * origin;
  }
  return matrix.ldlt().solve(right);
}

// Sum of the squared sines of the angles between the lines and the directions to the point.
inline double SquaredError(const std::vector<Ray>& rays, const Vector3d& point) {
  double sum = 0;
  for (const Ray& ray : rays) sum += (point - ray.origin).normalized().cross(ray.direction).squaredNorm();
  return sum;
}

// Repeated linear least squares, where the weights 1 / distance^2 turn distances into angles. Returns the best of all
// these points and a distant one. A point may be behind its cameras: the model projects such points too, and in
// captures, some nearly parallel or wrong observations fit best there.
inline Vector3d Triangulate(std::vector<Ray> rays, double distant) {
  Vector3d origin = Vector3d::Zero(), direction = Vector3d::Zero();
  for (const Ray& ray : rays) origin += ray.origin / static_cast<double>(rays.size()), direction += ray.direction;
  Vector3d best = origin + distant * direction.normalized();
  double least = SquaredError(rays, best);
  for (int k = 0; k < 6; ++k) {
    const Vector3d point = NearestPoint(rays);
    const double error = SquaredError(rays, point);  // NaN if the lines are parallel
    if (error < least) least = error, best = point;
    for (Ray& ray : rays) ray.weight = 1 / (point - ray.origin).squaredNorm();
  }
  return best;
}

// Sets all points of `data` from its cameras and observations.
inline void TriangulateAll(BundleData& data) {
  const std::vector<View> views = ViewsOf(data);
  double size = 0;  // of the set of cameras
  for (const View& view : views) size = std::max(size, (view.center - views[0].center).norm());
  std::vector<std::vector<Ray>> rays(data.num_points);
  for (const Sight& sight : SightsOfPoints(data, views)) {
    rays[sight.to - data.num_cameras].push_back({views[sight.from].center, sight.direction});
  }
  for (Index p = 0; p < data.num_points; ++p) {
    if (!rays[p].empty()) PointOf(data, p) = Triangulate(rays[p], 10 * size);
  }
}
