// SPDX-License-Identifier: Apache-2.0
// A camera in the world, in the form of the kernels: plain data, which may cross the boundary of an instruction set's
// namespace.
#pragma once

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/lenses/lens.h"

namespace vesta::splat {

// World to camera: t = R mu + T; x right, y down, z forward (COLMAP). Gaussians with z <= near are not seen, nor those
// whose means lie far outside the image (kGuardBand) or outside and which are deep (kDepthSpread).
struct PosedCamera {
  double R[9];  // row-major
  double T[3];
  double centre[3];  // of the camera in the world, -R^T T
  Lens lens;
  int width, height;  // of the image, pixels
  double near;
  double low_pass = kLowPass;  // variance that is added to both screen axes of a Gaussian, pixels squared
};

}  // namespace vesta::splat
