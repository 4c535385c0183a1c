// Splats and cameras as one problem, in the memory of a GPU.
#include "kernels/gaussian_splatting/device_camera.h"
#include "problems/gaussian_splatting/cameras/joint_linearization.inl"
#include "problems/gaussian_splatting/cameras/joint_problem.inl"
#include "problems/gaussian_splatting/cameras/joint_reduced.inl"
#include "problems/gaussian_splatting/model/device_splat_backend.h"

namespace vesta::gs {

template class JointLinearization<CudaBackend<float>>;
template class JointProblem<CudaBackend<float>>;
template class JointReducedSystem<CudaBackend<float>>;

}  // namespace vesta::gs
