// SPDX-License-Identifier: Apache-2.0
// The engine for GPU memory in float.
#include "kernels/core/cuda_backend.h"

namespace vesta {
using InstantiatedBackend = CudaBackend<float>;
}  // namespace vesta

#include "solver/internal/instantiate/engine.inl"
