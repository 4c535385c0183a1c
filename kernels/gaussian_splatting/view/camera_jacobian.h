// SPDX-License-Identifier: Apache-2.0
// The derivatives of a view's image by the pose and the lens of its camera, as products.
#pragma once

#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/view/splat_view.h"

namespace vesta::splat {

// The image of a view as a function of its camera's pose: products with the derivative J and its transpose.
//
// J = J_raster K: K moves the splats (project_kernels.h), J_raster is that of SplatView. The same bits for any number
// of threads.
//
// d_image = J xi. view: built of this model.
template <class S>
void ApplyPoseJ(const SplatView<S>& view, const Model<S>& model, const PoseTangent& xi, S* d_image,
                ViewWorkspace<S>& workspace);
// d_image = J_model dx + J xi, of parameters (laid out as those of the model) and pose at once, by one raster pass; xi
// may be null.
template <class S>
void ApplyModelAndPoseJ(const SplatView<S>& view, const Model<S>& model, const S* dx, const PoseTangent* xi, S* d_image,
                        ViewWorkspace<S>& workspace);
// J^T u. image: from view.Render.
template <class S>
PoseTangent ApplyPoseJT(const SplatView<S>& view, const Model<S>& model, const S* image, const S* u,
                        ViewWorkspace<S>& workspace);
// K^T cotangents, by rank: the same where J_raster^T u is there already (SplatView::AddJT leaves it in
// workspace.splat_sums).
template <class S>
PoseTangent PoseCotangent(const SplatView<S>& view, const Model<S>& model, const SplatTangent<S>* cotangents);

// The image of a view as a function of its lens (lens_motion.h): products with the derivative and its transpose.
//
// d_image = J delta. view: built of this model.
template <class S>
void ApplyLensJ(const SplatView<S>& view, const LensTangent& delta, S* d_image, ViewWorkspace<S>& workspace);
// J^T u from J_raster^T u, by rank (as PoseCotangent). The same bits for any number of threads.
template <class S>
LensTangent LensCotangent(const SplatView<S>& view, const SplatTangent<S>* cotangents);

}  // namespace vesta::splat
