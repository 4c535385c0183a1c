// SPDX-License-Identifier: Apache-2.0
// GPU memory and the library's CUDA stream, for host code without CUDA's headers. Implemented in vesta::core_cuda.
//
// All work runs in one stream, in the order of the calls, so calls need no synchronisation. All calls must come from
// the host thread that made the first call.
#pragma once

#include <cstddef>
#include <string>

#include "kernels/core/error.h"

namespace vesta {

// GPU memory is full. The failed call changes nothing, so the caller may retry with smaller batches.
class OutOfDeviceMemory : public Error {
 public:
  explicit OutOfDeviceMemory(const std::string& message) : Error(kOutOfMemory, message) {}
};

// Properties of the GPU.
struct DeviceInfo {
  bool present = false;    // a GPU exists
  bool usable = false;     // it can run this program's code
  std::string name;        // of the GPU, or the reason why it cannot be used
  std::size_t memory = 0;  // bytes
  int multiprocessors = 0;
  int capability = 0;  // 10 major + minor
};
// Properties of the first GPU, which vesta uses. Queried once per process. Never throws.
const DeviceInfo& QueryDevice();

namespace device {

// Allocates uninitialised memory from a pool that keeps freed memory. Returns null for 0 bytes. Throws
// OutOfDeviceMemory.
void* Allocate(std::size_t bytes);
void Free(void* memory) noexcept;
// Returns the pool's unused memory to the driver, so that the driver can merge fragments. Waits for all work.
void TrimPool();
// The next four functions run in stream order. Copies to and from the host wait until they are complete.
void SetZero(void* memory, std::size_t bytes);
void Copy(void* to, const void* from, std::size_t bytes);
void CopyFromHost(void* to, const void* from, std::size_t bytes);
void CopyToHost(void* to, const void* from, std::size_t bytes);
// Waits for all work; throws Error if any of it failed.
void Synchronize();

// Returns the value that `scalar` had at the previous call with the same pointer; 0 at the first call. Starts a copy
// for the next call, and waits only for the previous copy. At most 16 scalars are remembered: one more replaces the
// oldest, which then starts again with 0.
double ReadLagged(const double* scalar);
// Discards the copies of first[0 .. count - 1]. Their next ReadLagged returns 0.
void DiscardLagged(const double* first, std::size_t count);

// Bytes that can be allocated now: free device memory plus unused memory of the pool.
std::size_t FreeBytes();
// Bytes allocated now; their maximum since ResetPeak.
std::size_t BytesInUse();
std::size_t PeakBytes();
void ResetPeak();

}  // namespace device
}  // namespace vesta
