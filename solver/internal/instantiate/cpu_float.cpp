// SPDX-License-Identifier: Apache-2.0
// The engine for host memory in float.
#include "kernels/core/vector_backend.h"

namespace vesta {
using InstantiatedBackend = CpuBackend<float>;
}  // namespace vesta

#include "solver/internal/instantiate/engine.inl"
