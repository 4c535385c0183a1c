// SPDX-License-Identifier: Apache-2.0
// Gradient of a view's cost with respect to its own unknowns (pose, exposure, lens). It uses intermediate results of
// the gradient with respect to the Gaussians instead of a rendering pass.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "splatting/cameras/derivatives/image_products.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// A view with the intermediate results of its gradient, in the memory of backend B.
template <class B>
struct ProcessedView {
  std::size_t view = 0;  // index among the training views
  const splat::Model<float>& model;
  const TargetView<B>& target;
  const typename SplatBackend<B>::SplatView& splats;
  const splat::SplatTangent<float>* cotangents;  // derivatives of the cost by each splat's parameters, by depth rank
  typename B::ConstVectorView image, image_gradient;  // rendered image (for exposures); dCost/dImage
};

// The result has the order of FreeUnknowns. Users must include camera_jacobian.h (CPU) or device_camera.h (GPU), which
// define PoseCotangent and LensCotangent.
template <class B>
std::vector<double> GradientOf(const ProcessedView<B>& seen, const FreeUnknowns& free) {
  std::vector<double> gradient(static_cast<std::size_t>(free.num_tangent()));
  if (free.pose) {
    const splat::PoseTangent pose = PoseCotangent(seen.splats, seen.model, seen.cotangents);
    std::copy_n(pose.v, splat::kPoseTangent, gradient.begin());
  }
  ImageProducts<B> products(free.color_tangent());
  if (free.color) AddExposureProducts<B>(seen.image, seen.image_gradient, products);
  if (free.lens) {
    const splat::LensTangent lens = LensCotangent(seen.splats, seen.cotangents);
    std::copy_n(lens.v, free.lens_tangent(), gradient.begin() + free.Lens(0));
  }
  const std::vector<double> sums = products.Read();
  std::ranges::copy(sums, gradient.begin() + free.pose_tangent());
  return gradient;
}

}  // namespace vesta::gs
