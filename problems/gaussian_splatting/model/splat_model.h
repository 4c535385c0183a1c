// SPDX-License-Identifier: Apache-2.0
// Splats (parameters of Gaussians), selection by a box, and changes of spherical-harmonics (SH) degrees.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::gs {

// Layout: kernels/gaussian_splatting/formulas/layout.h.
struct SplatModel : splat::ModelLayout {
  std::vector<float> data;            // Size() values
  std::array<float, 3> background{};  // background colour of the training, 0..1
  bool has_background = false;        // false: the file does not contain it
  double eps2d = splat::kEps2d;       // 2D dilation of the training (Camera::eps2d)
  bool antialiased = false;           // trained with opacities compensated for the dilation (Camera::antialiased)
  std::array<double, 3> origin{};     // origin of the frame of the means, in world coordinates (scene_frame.h)

  const splat::ModelLayout& layout() const { return *this; }
  // Attributes of a Gaussian of the highest degree.
  int num_attributes() const { return splat::NumAttributes(sh_degree); }
  // Sets all parameters to zero.
  void Resize(const splat::ModelLayout& layout) {
    static_cast<splat::ModelLayout&>(*this) = layout;
    data.assign(static_cast<std::size_t>(Size()), 0.0f);
  }
  // The same, with one SH degree for all Gaussians.
  void Resize(int degree, Index gaussians) { Resize({.count = gaussians, .sh_degree = degree}); }
  // Attribute a (layout.h) of the first Rows(a) Gaussians; the others lack it.
  float* attribute(int a) { return data.data() + Offset(a); }
  const float* attribute(int a) const { return data.data() + Offset(a); }
  // Attribute a of any Gaussian; zero if it lacks the attribute.
  float Value(int a, Index gaussian) const { return gaussian < Rows(a) ? attribute(a)[gaussian] : 0.0f; }
};

// An axis-aligned box in the world, faces included.
struct Box {
  std::array<double, 3> low, high;
};

// Indices, ascending, of the Gaussians with means in the box. Takes SplatModel::origin into account.
std::vector<Index> GaussiansWithin(const SplatModel& model, const Box& box);

// A new order and new degrees for a model: Gaussian k of the result is Gaussian source[k]. SH bands that a Gaussian
// lacks in the new layout are dropped; new bands are zero.
struct DegreeOrder {
  std::vector<std::uint32_t> source;
  splat::ModelLayout layout;
};

// The order for new degrees, one per Gaussian: highest degree first, otherwise stable. Throws Error for a wrong number
// of degrees, or if a degree would grow.
DegreeOrder OrderByDegree(const splat::ModelLayout& layout, const std::vector<std::uint8_t>& degrees);

// The layout of a model of the Gaussians source[0], source[1], ... of a model with the given layout. Throws Error if
// one has a higher degree than the one before it.
splat::ModelLayout LayoutOfRows(const splat::ModelLayout& layout, const std::vector<std::uint32_t>& source);

SplatModel TakeGaussians(SplatModel model, const DegreeOrder& order);

// Gives all Gaussians the highest degree, in the same order. New bands are zero.
SplatModel AtOneDegree(SplatModel model);

// The SH degrees that the values of a model from a file imply: per Gaussian the highest band that is not zero. If a
// band is zero in all Gaussians, the training had not reached this band, and the result is the present degrees.
std::vector<std::uint8_t> StoredDegrees(const SplatModel& model);

// The model with these degrees, reordered.
SplatModel AtStoredDegrees(SplatModel model);

}  // namespace vesta::gs
