// SPDX-License-Identifier: Apache-2.0
// Instantiates the splatting problem for GPU memory.
#include "problems/gaussian_splatting/lm/splat_linearization.inl"
#include "problems/gaussian_splatting/lm/splat_problem.inl"
#include "problems/gaussian_splatting/model/device_splat_backend.h"

namespace vesta::gs {

template class SplatLinearization<CudaBackend<float>>;
template class SplatProblem<CudaBackend<float>>;

}  // namespace vesta::gs
