// Boxes along the axes of the world.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// From low to high in each of x, y and z; the faces are within.
struct Box {
  std::array<double, 3> low, high;
};

// The Gaussians whose means lie within the box, which is in the world of the model's file, ascending: not about its
// origin, where it has one.
std::vector<Index> GaussiansWithin(const SplatModel& model, const Box& box);

}  // namespace vesta::gs
