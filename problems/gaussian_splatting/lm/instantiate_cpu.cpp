// SPDX-License-Identifier: Apache-2.0
// Instantiates the splatting problem for host memory.
#include "problems/gaussian_splatting/lm/splat_linearization.inl"
#include "problems/gaussian_splatting/lm/splat_problem.inl"

namespace vesta::gs {

template class SplatLinearization<CpuBackend<float>>;
template class SplatLinearization<CpuBackend<double>>;
template class SplatProblem<CpuBackend<float>>;
template class SplatProblem<CpuBackend<double>>;

}  // namespace vesta::gs
