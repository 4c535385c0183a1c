// The gradient of a view's cost by its own unknowns, from what the passes for the splats' gradient left.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "kernels/gaussian_splatting/lens_motion.h"
#include "problems/gaussian_splatting/cameras/bend_column.h"
#include "problems/gaussian_splatting/cameras/image_products.h"
#include "problems/gaussian_splatting/cameras/view_unknowns.h"
#include "problems/gaussian_splatting/model/splat_backend.h"

namespace vesta::gs {

// A view whose gradient was just added, as the passes over it left things in the memory of B.
template <class B>
struct SeenView {
  std::size_t view = 0;  // of the training views
  const splat::Model<float>& model;
  const TargetView<B>& target;
  const typename SplatBackend<B>::SplatView& splats;
  const splat::SplatTangent<float>* cotangents;  // of the splats, by rank
  typename B::ConstView image, image_gradient;   // as rendered, where it takes part; of the cost by it
};

// By the view's unknowns, in the order of a step. Its users include what moves a view of B's: pose_jacobian.h and
// lens_jacobian.h, or device_camera.h.
template <class B>
std::vector<double> GradientOf(const SeenView<B>& seen, const FreeUnknowns& free) {
  B backend;
  std::vector<double> gradient(static_cast<std::size_t>(free.num_tangent()));
  if (free.pose) {
    const splat::PoseTangent pose = PoseCotangent(seen.splats, seen.model, seen.cotangents);
    std::copy_n(pose.v, splat::kPoseTangent, gradient.begin());
  }
  const Index plane = seen.image.size() / ImageShape::kChannels;
  for (int c = 0; free.color && c < ImageShape::kChannels; ++c) {
    const typename B::ConstView channel = seen.image_gradient.subspan(c * plane, plane);
    gradient[static_cast<std::size_t>(free.Gain(c))] = Dot(backend, seen.image.subspan(c * plane, plane), channel);
    gradient[static_cast<std::size_t>(free.Offset(c))] = Sum(backend, channel);
  }
  if (free.lens) {
    const splat::LensTangent lens = LensCotangent(seen.splats, seen.cotangents);
    std::copy_n(lens.v, free.pinhole_tangent(), gradient.begin() + free.Lens(0));
  }
  typename B::Vector column;
  for (int k = 0; k < free.radial_tangent(); ++k) {
    column.ResizeForOverwrite(seen.image.size());
    BendColumn<B>(seen.target, k, seen.image, column.view());
    gradient[static_cast<std::size_t>(free.Lens(free.Radial(k)))] =
        Dot(backend, typename B::ConstView(column.view()), seen.image_gradient);
  }
  return gradient;
}

}  // namespace vesta::gs
