// The curvature of a view's cost by its own unknowns.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/cameras/view_problem.h"

namespace vesta::gs {

// H = J^T W J of the view as it stands, without an exposure: square, options.free.num_tangent() numbers a side.
std::vector<double> ViewCurvature(const ViewProblemOptions& options, const splat::Model<float>& model,
                                  const TargetView<CpuBackend<float>>& target);

}  // namespace vesta::gs
