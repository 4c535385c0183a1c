// SPDX-License-Identifier: Apache-2.0
// The Gaussians of a scene as parameters, boxes around them, and the degrees of their harmonics.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::gs {

// Gaussians as parameters: data as the layout has them (kernels/gaussian_splatting/formulas/layout.h).
struct SplatModel : splat::ModelLayout {
  std::vector<float> data;
  std::array<float, 3> background{};  // the colour it was trained over, 0..1
  bool has_background = false;
  double eps2d = splat::kEps2d;    // that it was trained with (Camera::eps2d)
  std::array<double, 3> origin{};  // of the frame that the means are in; zero: the world's

  const splat::ModelLayout& layout() const { return *this; }
  // Of the Gaussians of the highest degree.
  int num_attributes() const { return splat::NumAttributes(sh_degree); }
  // Makes all parameters zero.
  void Resize(const splat::ModelLayout& layout) {
    static_cast<splat::ModelLayout&>(*this) = layout;
    data.assign(static_cast<std::size_t>(Size()), 0.0f);
  }
  // The same, of Gaussians that all have this degree.
  void Resize(int degree, Index gaussians) { Resize({.count = gaussians, .sh_degree = degree}); }
  // Of the first Rows(a) Gaussians.
  float* attribute(int a) { return data.data() + Offset(a); }
  const float* attribute(int a) const { return data.data() + Offset(a); }
  // Of any Gaussian: zero where it lacks the attribute.
  float Value(int a, Index gaussian) const { return gaussian < Rows(a) ? attribute(a)[gaussian] : 0.0f; }
};

// A box along the axes of the world. From low to high in each of x, y and z; the faces are within.
struct Box {
  std::array<double, 3> low, high;
};

// The Gaussians whose means lie within the box, which is in the world of the model's file, ascending: not about its
// origin, where it has one.
std::vector<Index> GaussiansWithin(const SplatModel& model, const Box& box);

// Gaussian k of a model to be is Gaussian source[k] of the one there is, without the bands that the layout leaves out,
// and with zeros in those that only the layout has.
struct DegreeOrder {
  std::vector<std::uint32_t> source;
  splat::ModelLayout layout;
};

// The order that gives each Gaussian the degree; among those of one degree it stays. Throws Error unless there is a
// degree for each, none above the one it has.
DegreeOrder OrderByDegree(const splat::ModelLayout& layout, const std::vector<std::uint8_t>& degrees);

// The layout of these Gaussians of a model. Throws Error where one has a higher degree than the one before it.
splat::ModelLayout LayoutOfRows(const splat::ModelLayout& layout, const std::vector<std::uint32_t>& source);

// The model that the order makes of this one.
SplatModel TakeGaussians(SplatModel model, const DegreeOrder& order);

// The model with the bands that Gaussians lack as zeros: all have its highest degree, in the order there is.
SplatModel AtOneDegree(SplatModel model);

// The degrees that the numbers of a model tell, as those of a file do: of each Gaussian that of its highest band that
// is not zero. Where a band is zero in all of them it was not trained yet, and all keep the degree they have.
std::vector<std::uint8_t> StoredDegrees(const SplatModel& model);

// The model with those.
SplatModel AtStoredDegrees(SplatModel model);

}  // namespace vesta::gs
