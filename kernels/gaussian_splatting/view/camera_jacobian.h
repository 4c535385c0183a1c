// SPDX-License-Identifier: Apache-2.0
// Products with the derivatives of a view's image with respect to the pose and the lens of the view's camera.
#pragma once

#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/view/splat_view.h"

namespace vesta::splat {

// The image of a view as a function of the pose: products with the derivative J and its transpose.
//
// J = J_raster K. K is the derivative of the splats with respect to the pose (CameraKernels), J_raster the derivative
// of the image with respect to the splats (SplatView). Results are bit-identical for any number of threads. view must
// be built from the same model.
//
// d_image = J xi.
template <class S>
void ApplyPoseJ(const SplatView<S>& view, const Model<S>& model, const PoseTangent& xi, S* d_image,
                ViewWorkspace<S>& workspace);
// d_image = J_model dx + J xi, in one raster pass. J_model is the derivative with respect to the model's parameters. dx
// has the model's layout. If xi is null, d_image = J_model dx.
template <class S>
void ApplyModelAndPoseJ(const SplatView<S>& view, const Model<S>& model, const S* dx, const PoseTangent* xi, S* d_image,
                        ViewWorkspace<S>& workspace);
// Returns J^T u. image: from view.Render.
template <class S>
PoseTangent ApplyPoseJT(const SplatView<S>& view, const Model<S>& model, const S* image, const S* u,
                        ViewWorkspace<S>& workspace);
// Returns K^T cotangents. cotangents: J_raster^T u, by rank. AddJT of SplatView stores it in workspace.splat_sums.
template <class S>
PoseTangent PoseCotangent(const SplatView<S>& view, const Model<S>& model, const SplatTangent<S>* cotangents);

// The same for the lens (lens_motion.h).
//
// d_image = J delta.
template <class S>
void ApplyLensJ(const SplatView<S>& view, const LensTangent& delta, S* d_image, ViewWorkspace<S>& workspace);
// Returns J^T u. cotangents: J_raster^T u, by rank (see PoseCotangent).
template <class S>
LensTangent LensCotangent(const SplatView<S>& view, const SplatTangent<S>* cotangents);

}  // namespace vesta::splat
