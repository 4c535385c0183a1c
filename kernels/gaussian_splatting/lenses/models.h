// SPDX-License-Identifier: Apache-2.0
// The list of lens models. To add one, write its header in this folder and add its name to LensModels. The projection,
// the readers of cameras, and the tests iterate over the list.
#pragma once

#include <string_view>
#include <type_traits>

#include "kernels/gaussian_splatting/lenses/pinhole.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <template <class> class... Models>
requires(LensModel<Models<float>>&&...) struct LensList {
};

using LensModels = LensList<Pinhole>;

// M: the model with this index in the list.
template <class S, class Body, template <class> class M, template <class> class... Others>
VESTA_HD decltype(auto) OfModel(LensList<M, Others...>, int index, const Body& body) {
  if constexpr (sizeof...(Others) > 0) {
    if (index > 0) return OfModel<S>(LensList<Others...>(), index - 1, body);
  }
  return body(std::type_identity<M<S>>());
}

// Index of the model with that name, or -1.
template <template <class> class... Models>
constexpr int IndexOf(LensList<Models...>, std::string_view name) {
  int index = 0, found = -1;
  ((found = name == Models<double>::kName ? index : found, ++index), ...);
  return found;
}

// The pixel of t, a point in camera coordinates.
VESTA_HD inline void PixelOf(const Lens& lens, const double t[3], double& u, double& v) {
  OfModel<double>(LensModels(), lens.model, [&](auto model) {
    double x, y;
    decltype(model)::type::Plane(t, x, y);
    LensConstants<double>(lens).Pixel(x, y, u, v);
  });
}
// Computes the point t, in camera coordinates, that has this depth and projects to pixel (u, v).
inline void PointAt(const Lens& lens, double u, double v, double depth, double t[3]) {
  OfModel<double>(LensModels(), lens.model, [&](auto model) {
    decltype(model)::type::PointAt((u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy, depth, t);
  });
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
