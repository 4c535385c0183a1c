// SPDX-License-Identifier: Apache-2.0
// The gradient of a view's cost by its own unknowns, from what the passes for the splats' gradient left.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "splatting/cameras/derivatives/image_products.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// A view whose gradient was just added, as the passes over it left things in the memory of B.
template <class B>
struct SeenView {
  std::size_t view = 0;  // of the training views
  const splat::Model<float>& model;
  const TargetView<B>& target;
  const typename SplatBackend<B>::SplatView& splats;
  const splat::SplatTangent<float>* cotangents;       // of the splats, by rank
  typename B::ConstVectorView image, image_gradient;  // as rendered, where it takes part; of the cost by it
};

// By the view's unknowns, in the order of a step. Its users include what moves a view of B's: camera_jacobian.h
// or device_camera.h.
template <class B>
std::vector<double> GradientOf(const SeenView<B>& seen, const FreeUnknowns& free) {
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
