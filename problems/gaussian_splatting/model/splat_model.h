// SPDX-License-Identifier: Apache-2.0
// The Gaussians of a scene as parameters, selection by a box, and the degrees of their spherical harmonics.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::gs {

// Parameters of the Gaussians, in the layout of kernels/gaussian_splatting/formulas/layout.h.
struct SplatModel : splat::ModelLayout {
  std::vector<float> data;
  std::array<float, 3> background{};  // background colour of the training, 0..1
  bool has_background = false;
  double eps2d = splat::kEps2d;    // 2D dilation of the training (Camera::eps2d)
  std::array<double, 3> origin{};  // of the frame of the means, in the world; zero: the world's frame

  const splat::ModelLayout& layout() const { return *this; }
  // For Gaussians of the highest degree.
  int num_attributes() const { return splat::NumAttributes(sh_degree); }
  // Sets all parameters to zero.
  void Resize(const splat::ModelLayout& layout) {
    static_cast<splat::ModelLayout&>(*this) = layout;
    data.assign(static_cast<std::size_t>(Size()), 0.0f);
  }
  // The same with one degree for all Gaussians.
  void Resize(int degree, Index gaussians) { Resize({.count = gaussians, .sh_degree = degree}); }
  // Values of the first Rows(a) Gaussians.
  float* attribute(int a) { return data.data() + Offset(a); }
  const float* attribute(int a) const { return data.data() + Offset(a); }
  // For any Gaussian: zero if it lacks the attribute.
  float Value(int a, Index gaussian) const { return gaussian < Rows(a) ? attribute(a)[gaussian] : 0.0f; }
};

// An axis-aligned box in the world, from low to high in x, y and z, faces included.
struct Box {
  std::array<double, 3> low, high;
};

// Indices, ascending, of the Gaussians whose means lie in the box. The box is in world coordinates, even if the model
// has an origin of its own.
std::vector<Index> GaussiansWithin(const SplatModel& model, const Box& box);

// How to reorder a model: Gaussian k of the result is Gaussian source[k]. Bands that the new layout lacks are dropped;
// bands that the old one lacks become zero.
struct DegreeOrder {
  std::vector<std::uint32_t> source;
  splat::ModelLayout layout;
};

// The order for these degrees, one per Gaussian; Gaussians of one degree keep their order. Throws Error if the number
// of degrees is wrong or a degree is above the Gaussian's present one.
DegreeOrder OrderByDegree(const splat::ModelLayout& layout, const std::vector<std::uint8_t>& degrees);

// The layout of the Gaussians `source` of a model. Throws Error if one has a higher degree than the one before it.
splat::ModelLayout LayoutOfRows(const splat::ModelLayout& layout, const std::vector<std::uint32_t>& source);

// Returns the model in this order.
SplatModel TakeGaussians(SplatModel model, const DegreeOrder& order);

// Gives all Gaussians the highest degree, in the same order. Bands they lacked become zero.
SplatModel AtOneDegree(SplatModel model);

// The degrees that the values imply, as for models read from files: the highest band of each Gaussian that is not zero.
// If a band is zero in all Gaussians, it was not trained yet, and all keep their present degree.
std::vector<std::uint8_t> StoredDegrees(const SplatModel& model);

// The model with the degrees of StoredDegrees.
SplatModel AtStoredDegrees(SplatModel model);

}  // namespace vesta::gs
