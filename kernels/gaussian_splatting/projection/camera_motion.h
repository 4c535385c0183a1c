// SPDX-License-Identifier: Apache-2.0
// Rigid motions of a camera: elements of SE(3), with the tangents of project_kernels.h.
#pragma once

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"

namespace vesta::splat {

// Maps a point t in camera coordinates to R(quaternion) t + translation. The default is the identity.
struct CameraMotion {
  double quaternion[4] = {1, 0, 0, 0};  // w, x, y, z, unit length
  double translation[3] = {};           // world units

  // Rotation angle in radians, 0 to pi.
  double Angle() const;
};

// Returns the motion that applies `motion`, then xi (a retraction). xi maps t to exp(rotation) t + translation.
CameraMotion Compose(const PoseTangent& xi, const CameraMotion& motion);

// The motion that maps one pose (t = R mu + T for a world point mu, R row-major) to another.
CameraMotion MotionBetween(const double R[9], const double T[3], const double to_R[9], const double to_T[3]);

// Applies the motion to a pose, or to a camera and its centre. The default motion changes no bit of them.
void MovePose(const CameraMotion& motion, double R[9], double T[3]);
PosedCamera Moved(const PosedCamera& camera, const CameraMotion& motion);

}  // namespace vesta::splat
