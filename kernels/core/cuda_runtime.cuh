// SPDX-License-Identifier: Apache-2.0
// The library's stream, and errors of the CUDA runtime as Error. For files that see CUDA's headers.
#pragma once

#include <cuda_runtime_api.h>

namespace vesta::device {

// Made at first use. Throws Error where there is none.
cudaStream_t Stream();

// False where memory was lacking, true for success; of anything else throws Error "what: CUDA's message".
bool FoundMemory(cudaError_t status, const char* what);
// As that, and throws OutOfDeviceMemory where memory was lacking.
void CheckCuda(cudaError_t status, const char* what);

}  // namespace vesta::device
