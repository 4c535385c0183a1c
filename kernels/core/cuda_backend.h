// SPDX-License-Identifier: Apache-2.0
// Vector algebra in GPU memory (cuda_backend.cu); programs link vesta::core_cuda.
#pragma once

#include "kernels/core/device_buffer.h"
#include "kernels/core/vector_backend.h"

namespace vesta {

template <class S>
using CudaBackend = VectorBackend<S, Device>;

static_assert(Backend<CudaBackend<float>> && Backend<CudaBackend<double>>);

}  // namespace vesta
