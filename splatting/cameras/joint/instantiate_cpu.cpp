// SPDX-License-Identifier: Apache-2.0
// Splats and cameras as one problem, in the memory of the host.
#include "kernels/gaussian_splatting/view/camera_jacobian.h"
#include "splatting/cameras/joint/joint_linearization.inl"
#include "splatting/cameras/joint/joint_problem.inl"
#include "splatting/cameras/joint/joint_reduced.inl"

namespace vesta::gs {

template class JointLinearization<CpuBackend<float>>;
template class JointLinearization<CpuBackend<double>>;
template class JointProblem<CpuBackend<float>>;
template class JointProblem<CpuBackend<double>>;
template class JointReducedSystem<CpuBackend<float>>;
template class JointReducedSystem<CpuBackend<double>>;

}  // namespace vesta::gs
