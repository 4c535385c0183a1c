// SPDX-License-Identifier: Apache-2.0
// The library's CUDA stream, and conversion of CUDA errors to Error. Only for files that include CUDA's headers.
#pragma once

#include <cuda_runtime_api.h>

namespace vesta::device {

// The library's stream, created by the first call. Throws Error if no GPU is usable.
cudaStream_t Stream();

// Returns true for success and false if memory ran out. For other failures throws Error "what: CUDA's message".
bool FoundMemory(cudaError_t status, const char* what);
// Throws OutOfDeviceMemory if memory ran out, and Error for any other failure.
void CheckCuda(cudaError_t status, const char* what);

}  // namespace vesta::device
