// Splats and cameras as one problem, in the memory of the host.
#include "kernels/gaussian_splatting/lens_jacobian.h"
#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/joint_linearization.inl"
#include "problems/gaussian_splatting/cameras/joint_problem.inl"
#include "problems/gaussian_splatting/cameras/joint_reduced.inl"

namespace vesta::gs {

template class JointLinearization<CpuBackend<float>>;
template class JointLinearization<CpuBackend<double>>;
template class JointProblem<CpuBackend<float>>;
template class JointProblem<CpuBackend<double>>;
template class JointReducedSystem<CpuBackend<float>>;
template class JointReducedSystem<CpuBackend<double>>;

}  // namespace vesta::gs
