// SPDX-License-Identifier: Apache-2.0
// The engine for host memory in double.
#include "kernels/core/vector_backend.h"

namespace vesta {
using InstantiatedBackend = CpuBackend<double>;
}  // namespace vesta

#include "solver/internal/instantiate/engine.inl"
