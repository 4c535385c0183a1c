// SPDX-License-Identifier: Apache-2.0
// CUDA instantiations of the joint problem of splats and cameras.
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "splatting/cameras/joint/joint_linearization.inl"
#include "splatting/cameras/joint/joint_problem.inl"
#include "splatting/cameras/joint/joint_reduced.inl"

namespace vesta::gs {

template class JointLinearization<CudaBackend<float>>;
template class JointProblem<CudaBackend<float>>;
template class JointReducedSystem<CudaBackend<float>>;

}  // namespace vesta::gs
