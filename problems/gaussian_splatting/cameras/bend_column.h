// The column of a view's Jacobian that belongs to a coefficient of radial distortion.
#pragma once

#include "kernels/core/for_each.h"
#include "problems/gaussian_splatting/cameras/bend_derivative.h"
#include "problems/gaussian_splatting/model/splat_backend.h"

namespace vesta::gs {

// k: 0 for k1, 1 for k2. about: the lens, as given, that photographs are unbent about, for the target's size. image,
// column: three planes of the target's image, in the memory of B.
template <class B>
void BendColumn(const TargetView<B>& target, const splat::Lens& about, int k, typename B::ConstView image,
                typename B::View column) {
  constexpr Index kGrain = 1 << 14;  // pixels
  const splat::PosedCamera& camera = target.camera;
  const std::uint8_t* const mask = target.mask.size() > 0 ? target.mask.data() : nullptr;
  ForEach<typename B::Space>(
      Index{camera.width} * camera.height, kGrain,
      BendDerivative<typename B::Scalar>{image.data(), mask, column.data(), camera.width, camera.height, about, k + 1});
}

}  // namespace vesta::gs
