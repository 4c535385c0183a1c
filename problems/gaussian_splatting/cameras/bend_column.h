// The column of a view's Jacobian that belongs to a coefficient of radial distortion.
#pragma once

#include "kernels/core/for_each.h"
#include "kernels/gaussian_splatting/posed_camera.h"
#include "problems/gaussian_splatting/cameras/bend_derivative.h"

namespace vesta::gs {

// k: 0 for k1, 1 for k2. image, column: three planes of the camera's image, in the memory of B.
template <class B>
void BendColumn(const splat::PosedCamera& camera, int k, typename B::ConstView image, typename B::View column) {
  constexpr Index kGrain = 1 << 14;  // pixels
  ForEach<typename B::Space>(
      Index{camera.width} * camera.height, kGrain,
      BendDerivative<typename B::Scalar>{image.data(), column.data(), camera.width, camera.height, camera.lens, k + 1});
}

}  // namespace vesta::gs
