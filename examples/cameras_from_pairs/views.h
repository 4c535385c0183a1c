// SPDX-License-Identifier: Apache-2.0
// Camera poses, and conversions between them and the parameters of a BAL file
// (problems/bundle_adjustment/projection.h).
#pragma once

#include <Eigen/Geometry>
#include <numbers>
#include <vector>

#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/projection.h"
#include "solver/rotation.h"

using Eigen::Quaterniond;
using Eigen::Vector3d;
using vesta::Index;
using vesta::bundle::BundleData;

constexpr double kDegree = std::numbers::pi / 180;

struct View {
  Quaterniond rotation = Quaterniond::Identity();  // from camera to world coordinates
  Vector3d center = Vector3d::Zero();
};

// Pose of view `to` in the coordinates of view `from`, without the distance.
struct Pair {
  Index from = 0, to = 0;
  Quaterniond rotation;
  Vector3d direction;
};

// `to` is seen from `from` in this direction, in world coordinates. Nodes are indices of views, then of points.
struct Sight {
  Index from = 0, to = 0;
  Vector3d direction;
};

inline double* CameraOf(BundleData& data, Index i) { return data.x.data() + vesta::bundle::kCameraSize * i; }
inline const double* CameraOf(const BundleData& data, Index i) {
  return data.x.data() + vesta::bundle::kCameraSize * i;
}
inline Eigen::Map<Vector3d> PointOf(BundleData& data, Index i) {
  return Vector3d::Map(CameraOf(data, data.num_cameras) + vesta::bundle::kPointSize * i);
}

// A camera maps X to R X + t: R is the inverse of View::rotation, and t = -R center.
inline View ViewOf(const double* camera) {
  double q[4];
  vesta::AngleAxisToQuaternion(camera, q);
  const Quaterniond rotation = Quaterniond(q[0], q[1], q[2], q[3]).conjugate();
  return {rotation, rotation * -Vector3d::Map(camera + 3)};
}
inline void SetView(const View& view, double* camera) {
  const Quaterniond inverse = view.rotation.conjugate();
  const double q[4] = {inverse.w(), inverse.x(), inverse.y(), inverse.z()};
  vesta::QuaternionToAngleAxis(q, camera);
  Vector3d::Map(camera + 3) = inverse * -view.center;
}
inline std::vector<View> ViewsOf(const BundleData& data) {
  std::vector<View> views;
  for (Index i = 0; i < data.num_cameras; ++i) views.push_back(ViewOf(CameraOf(data, i)));
  return views;
}

// Direction of the observed point in camera coordinates. A fixed-point iteration removes the distortion.
inline Vector3d RayOf(const vesta::bundle::Observation& observation, const double* camera) {
  const double lens_alone[] = {0, 0, 0, 0, 0, 0, camera[6], camera[7], camera[8]};
  const auto lens = vesta::bundle::MakeCamera(lens_alone);
  const Vector3d distorted(observation.pixel[0] / lens.focal, observation.pixel[1] / lens.focal, -1);
  Vector3d ray = distorted;
  for (int i = 0; i < 20; ++i) ray.head<2>() = distorted.head<2>() / Project(lens, ray.data()).distortion;
  return ray.normalized();
}

// From each observing view to its point, with the rotations of `views` and the lenses of `data`. Point p is node
// data.num_cameras + p.
inline std::vector<Sight> SightsOfPoints(const BundleData& data, const std::vector<View>& views) {
  std::vector<Sight> sights;
  for (const auto& o : data.observations) {
    const Vector3d direction = views[o.camera].rotation * RayOf(o, CameraOf(data, o.camera));
    sights.push_back({o.camera, data.num_cameras + o.point, direction});
  }
  return sights;
}
