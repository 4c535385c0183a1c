// SPDX-License-Identifier: Apache-2.0
// The Gaussians of a scene as parameters, and boxes around them.
#pragma once

#include <array>
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
  double low_pass = splat::kLowPass;  // that it was trained with (Camera::low_pass)
  std::array<double, 3> origin{};     // of the frame that the means are in; zero: the world's

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

// Boxes along the axes of the world.

// From low to high in each of x, y and z; the faces are within.
struct Box {
  std::array<double, 3> low, high;
};

// The Gaussians whose means lie within the box, which is in the world of the model's file, ascending: not about its
// origin, where it has one.
std::vector<Index> GaussiansWithin(const SplatModel& model, const Box& box);

}  // namespace vesta::gs
