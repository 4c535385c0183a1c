// SPDX-License-Identifier: Apache-2.0
// Memory of the GPU and its one stream of work, for host code that does not include CUDA's headers. The bodies are in
// vesta::core_cuda.
//
// All work of the library goes through one stream, in the order of the calls, so that nothing here needs events; calls
// come from one thread of the host, that which asked first.
#pragma once

#include <cstddef>
#include <string>

#include "kernels/core/error.h"

namespace vesta {

// The device has no room for an allocation. The request left nothing behind: smaller batches may be tried.
class OutOfDeviceMemory : public Error {
 public:
  explicit OutOfDeviceMemory(const std::string& message) : Error(kOutOfMemory, message) {}
};

// What is known of the GPU without using it.
struct DeviceInfo {
  bool present = false;    // there is one
  bool usable = false;     // and it can run this program's code
  std::string name;        // of the GPU, or why there is none to use
  std::size_t memory = 0;  // bytes
  int multiprocessors = 0;
  int capability = 0;  // 10 major + minor
};
// Of the GPU in use, the first one; asked once.
const DeviceInfo& QueryDevice();

namespace device {

// Uninitialised, from a pool that keeps what is freed. Throws OutOfDeviceMemory; null for 0 bytes.
void* Allocate(std::size_t bytes);
void Free(void* memory) noexcept;
// Gives the pool's unused memory back to the driver, which can join pieces. Waits for all work.
void TrimPool();
// In the order of the stream; the copies to and from the host wait for their end.
void SetZero(void* memory, std::size_t bytes);
void Copy(void* to, const void* from, std::size_t bytes);
void CopyFromHost(void* to, const void* from, std::size_t bytes);
void CopyToHost(void* to, const void* from, std::size_t bytes);
// Waits for all work, and throws Error where any of it failed.
void Synchronize();

// The value at `scalar`, or the value it had at the previous call for this scalar, but never an older one; 0 at the
// first call. Waits at most for the copy that the previous call began.
double ReadLagged(const double* scalar);
// Forgets what earlier calls saw of these.
void ForgetLagged(const double* first, std::size_t count);

// Bytes that could be allocated now: what the device has left and what the pool keeps unused.
std::size_t FreeBytes();
// Bytes in use now, and the most there were since the last call of ResetPeak.
std::size_t BytesInUse();
std::size_t PeakBytes();
void ResetPeak();

}  // namespace device
}  // namespace vesta
