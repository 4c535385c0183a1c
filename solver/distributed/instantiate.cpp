// SPDX-License-Identifier: Apache-2.0
// Distributed problems in host memory.
#include "solver/distributed/distributed_linearization.inl"
#include "solver/distributed/distributed_problem.inl"
#include "solver/distributed/distributed_reduced.inl"

namespace vesta {

template class DistributedProblem<CpuBackend<double>>;
template class DistributedProblem<CpuBackend<float>>;
template class DistributedLinearization<CpuBackend<double>>;
template class DistributedLinearization<CpuBackend<float>>;
template class DistributedReducedSystem<CpuBackend<double>>;
template class DistributedReducedSystem<CpuBackend<float>>;

}  // namespace vesta
