// SPDX-License-Identifier: Apache-2.0
// Products with the derivatives of a view's image with respect to the pose and the lens of its camera.
#pragma once

#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/view/splat_view.h"

namespace vesta::splat {

// The image of a view as a function of its camera's pose: products with the derivative J and its transpose.
//
// J = J_raster K. K is the derivative of the splats (project_kernels.h), and J_raster the derivative of the image
// (SplatView). Bit-identical for any number of threads.
//
// d_image = J xi. view: built from this model.
template <class S>
void ApplyPoseJ(const SplatView<S>& view, const Model<S>& model, const PoseTangent& xi, S* d_image,
                ViewWorkspace<S>& workspace);
// d_image = J_model dx + J xi: the derivatives by parameters and pose, in one raster pass. dx has the layout of the
// model. xi may be null.
template <class S>
void ApplyModelAndPoseJ(const SplatView<S>& view, const Model<S>& model, const S* dx, const PoseTangent* xi, S* d_image,
                        ViewWorkspace<S>& workspace);
// Returns J^T u. image: from view.Render.
template <class S>
PoseTangent ApplyPoseJT(const SplatView<S>& view, const Model<S>& model, const S* image, const S* u,
                        ViewWorkspace<S>& workspace);
// Returns K^T cotangents, by rank, if J_raster^T u is already available (SplatView::AddJT stores it in
// workspace.splat_sums).
template <class S>
PoseTangent PoseCotangent(const SplatView<S>& view, const Model<S>& model, const SplatTangent<S>* cotangents);

// The image of a view as a function of its lens (lens_motion.h): products with the derivative J and its transpose.
//
// d_image = J delta. view: built from this model.
template <class S>
void ApplyLensJ(const SplatView<S>& view, const LensTangent& delta, S* d_image, ViewWorkspace<S>& workspace);
// Returns J^T u from J_raster^T u, by rank (see PoseCotangent). Bit-identical for any number of threads.
template <class S>
LensTangent LensCotangent(const SplatView<S>& view, const SplatTangent<S>* cotangents);

}  // namespace vesta::splat
