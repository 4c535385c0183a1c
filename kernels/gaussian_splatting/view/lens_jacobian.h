// The image of a view as a function of its lens (lens_motion.h): products with the derivative and its transpose.
#pragma once

#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/gaussian_splatting/view/splat_view.h"

namespace vesta::splat {

// d_image = J delta. view: built of this model.
template <class S>
void ApplyLensJ(const SplatView<S>& view, const LensTangent& delta, S* d_image, ViewWorkspace<S>& workspace);
// J^T u from J_raster^T u, by rank (as PoseCotangent). The same bits for any number of threads.
template <class S>
LensTangent LensCotangent(const SplatView<S>& view, const SplatTangent<S>* cotangents);

}  // namespace vesta::splat
