// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/derivatives/view_curvature.inl"

namespace vesta::gs {

template std::vector<double> ViewCurvature(const FreeUnknowns&, const std::array<double, 3>&,
                                           const splat::Model<float>&, const TargetView<CpuBackend<float>>&);

}  // namespace vesta::gs
