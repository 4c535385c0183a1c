// The Gaussians of a scene as parameters.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/layout.h"

namespace vesta::gs {

// Gaussians as parameters, structure of arrays: attribute a of Gaussian i is data[a * count + i], attributes in the
// order of kernels/gaussian_splatting/layout.h.
struct SplatModel {
  int sh_degree = 0;  // 0..3
  Index count = 0;
  std::vector<float> data;
  std::array<float, 3> background{};  // the colour it was trained over, 0..1
  bool has_background = false;
  std::array<double, 3> origin{};  // of the frame that the means are in; zero: the world's

  int num_attributes() const { return splat::NumAttributes(sh_degree); }
  void Resize(int degree, Index gaussians) {
    sh_degree = degree;
    count = gaussians;
    data.assign(static_cast<std::size_t>(splat::NumAttributes(degree) * gaussians), 0.0f);
  }
  float* attribute(int a) { return data.data() + a * count; }
  const float* attribute(int a) const { return data.data() + a * count; }
};

}  // namespace vesta::gs
