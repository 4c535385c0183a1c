// The curvature of a view's cost by its own unknowns, in the memory of B.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/model/splat_backend.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// H = J^T W J of the view as it stands, without an exposure, by the default weights: square, free.num_tangent() numbers
// a side. Body in view_curvature.inl.
template <class B>
std::vector<double> ViewCurvature(const FreeUnknowns& free, const std::array<double, 3>& background,
                                  const splat::Model<float>& model, const TargetView<B>& target);

}  // namespace vesta::gs
