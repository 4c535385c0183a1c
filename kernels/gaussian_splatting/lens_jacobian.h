// The image of a view as a function of its lens: products with the derivative and its transpose.
//
// The lens moves splats alone: wider by a factor it stretches means and footprints about the principal point, all but
// the low-pass filter's share, and colours and depths stay. So what is needed is in the splats. Where a projection is
// taken at the border of what the lens shows (lens.h, Shows), that place is held fast.
#pragma once

#include "kernels/gaussian_splatting/splat_view.h"

namespace vesta::splat {

// A tangent of a pinhole, or a cotangent: of the logarithms of the focal lengths, then of the principal point in focal
// lengths. So it is the same for a smaller image.
inline constexpr int kLensTangent = 4;
struct LensTangent {
  double v[kLensTangent] = {};  // log fx, log fy, cx / fx, cy / fy

  LensTangent& operator+=(const LensTangent& other) {
    for (int k = 0; k < kLensTangent; ++k) v[k] += other.v[k];
    return *this;
  }
};

// d_image = J delta. view: built of this model.
template <class S>
void ApplyLensJ(const SplatView<S>& view, const LensTangent& delta, S* d_image, ViewWorkspace<S>& workspace);
// J^T u from J_raster^T u, by rank (as PoseCotangent). The same bits for any number of threads.
template <class S>
LensTangent LensCotangent(const SplatView<S>& view, const SplatTangent<S>* cotangents);

}  // namespace vesta::splat
