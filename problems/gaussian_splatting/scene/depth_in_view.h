// SPDX-License-Identifier: Apache-2.0
// Runs on host and device.
#pragma once

#include "kernels/core/hd.h"
#include "kernels/gaussian_splatting/lenses/models.h"
#include "kernels/math/isa.h"

namespace vesta::gs {
inline namespace VESTA_ISA {

// Depth (z in camera coordinates) of a world point if it is in front of the camera and inside the image; otherwise 0.
// Camera coordinates are R point + T; R is row-major. Camera: has the members lens, width and height, such as
// gs::Camera and splat::PosedCamera.
template <class Camera>
VESTA_HD inline double DepthInView(const double* R, const double* T, const Camera& camera, const float* point) {
  double p[3];
  for (int i = 0; i < 3; ++i) p[i] = R[3 * i] * point[0] + R[3 * i + 1] * point[1] + R[3 * i + 2] * point[2] + T[i];
  if (!(p[2] > 0)) return 0;
  double u, v;
  splat::PixelOf(camera.lens, p, u, v);
  return u >= 0 && u <= camera.width && v >= 0 && v <= camera.height ? p[2] : 0;
}

}  // namespace VESTA_ISA
}  // namespace vesta::gs
