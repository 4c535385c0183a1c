// SPDX-License-Identifier: Apache-2.0
// Rigid motions of a camera: the group SE(3) whose tangents are those of project_kernels.h.
#pragma once

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"

namespace vesta::splat {

// In the camera's own frame: a point t in camera coordinates goes to R(quaternion) t + translation. Nothing moves by
// default.
struct CameraMotion {
  double quaternion[4] = {1, 0, 0, 0};  // w, x, y, z, of unit length
  double translation[3] = {};           // world units

  // The angle it turns by, radians, 0 to pi.
  double Angle() const;
};

// The retraction: first the motion, then exp(rotation) t + translation of xi.
CameraMotion Compose(const PoseTangent& xi, const CameraMotion& motion);

// The motion that brings one pose (t = R mu + T, R row-major) to another.
CameraMotion MotionBetween(const double R[9], const double T[3], const double to_R[9], const double to_T[3]);

// A pose (t = R mu + T, R row-major) as it is after the motion; and a camera, with its centre. By the motion of default
// they keep every bit.
void MovePose(const CameraMotion& motion, double R[9], double T[3]);
PosedCamera Moved(const PosedCamera& camera, const CameraMotion& motion);

}  // namespace vesta::splat
