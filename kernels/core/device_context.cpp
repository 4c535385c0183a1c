// SPDX-License-Identifier: Apache-2.0
// The GPU in use, its stream, its memory pool, and lagged reads of scalars (ReadLagged).
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/cuda_runtime.cuh"
#include "kernels/core/device_kernels.h"
#include "kernels/core/device_memory.h"

namespace vesta {
namespace {

constexpr int kDevice = 0;  // CUDA's index of the first GPU

}  // namespace

namespace device {
namespace {

// A scalar whose value is being copied to the host.
struct LaggedReading {
  const double* scalar = nullptr;
  cudaEvent_t arrived = nullptr;
  bool pending = false;
};
constexpr std::size_t kMaxReadings = 16;

struct Context {
  cudaStream_t stream = nullptr;
  // Pinned host memory; reading i is copied to landing[i].
  double* landing = nullptr;
  cudaMemPool_t pool = nullptr;
  std::array<LaggedReading, kMaxReadings> readings{};
  std::size_t next_reading = 0;
  std::unordered_map<void*, std::size_t> sizes;
  std::size_t in_use = 0, peak = 0;

  Context() {
    const DeviceInfo& info = QueryDevice();
    if (!info.usable) Fail(kUnavailable, "no GPU to use: {}", info.name);
    CheckCuda(cudaSetDevice(kDevice), "cudaSetDevice");
    CheckCuda(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "cudaStreamCreate");
    CheckCuda(cudaMallocHost(reinterpret_cast<void**>(&landing), kMaxReadings * sizeof(double)), "cudaMallocHost");
    for (LaggedReading& reading : readings) {
      CheckCuda(cudaEventCreateWithFlags(&reading.arrived, cudaEventDisableTiming), "cudaEventCreate");
    }
    // Freed memory stays in the pool: every step frees and allocates linearizations of the same sizes.
    CheckCuda(cudaDeviceGetDefaultMemPool(&pool, kDevice), "cudaDeviceGetDefaultMemPool");
    std::uint64_t keep = std::numeric_limits<std::uint64_t>::max();
    CheckCuda(cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &keep), "cudaMemPoolSetAttribute");
  }
};

// Never destroyed: static buffers may be freed later. The driver releases everything at exit.
Context& TheContext() {
  static Context* context = new Context;
  return *context;
}

}  // namespace

bool FoundMemory(cudaError_t status, const char* what) {
  if (status == cudaSuccess) return true;
  cudaGetLastError();  // clears the error, so that the next launch does not report it
  if (status == cudaErrorMemoryAllocation) return false;
  Fail(kUnavailable, "{}: {}", what, cudaGetErrorString(status));
}

void CheckCuda(cudaError_t status, const char* what) {
  if (!FoundMemory(status, what)) throw OutOfDeviceMemory(fmt::format("GPU memory is full: {}", what));
}

cudaStream_t Stream() { return TheContext().stream; }

void* Allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  Context& context = TheContext();
  void* memory = nullptr;
  const auto allocate = [&] { return FoundMemory(cudaMallocAsync(&memory, bytes, context.stream), "cudaMallocAsync"); };
  bool found = allocate();
  if (!found) {
    // The pool may hold enough memory, but in small fragments.
    TrimPool();
    found = allocate();
  }
  if (!found) {
    throw OutOfDeviceMemory(fmt::format(
        "cannot allocate {:.1f} MiB on the GPU: {:.1f} of {:.1f} MiB are in use", static_cast<double>(bytes) / 1048576,
        static_cast<double>(context.in_use) / 1048576, static_cast<double>(QueryDevice().memory) / 1048576));
  }
  context.sizes[memory] = bytes;
  context.in_use += bytes;
  context.peak = std::max(context.peak, context.in_use);
  return memory;
}

void Free(void* memory) noexcept {
  if (memory == nullptr) return;
  Context& context = TheContext();
  const auto found = context.sizes.find(memory);
  if (found != context.sizes.end()) {
    context.in_use -= found->second;
    context.sizes.erase(found);
  }
  // An error returned here comes from an earlier call; the next call that may throw reports it.
  static_cast<void>(cudaFreeAsync(memory, context.stream));
}

void TrimPool() {
  Synchronize();
  CheckCuda(cudaMemPoolTrimTo(TheContext().pool, 0), "cudaMemPoolTrimTo");
}

void SetZero(void* memory, std::size_t bytes) {
  if (bytes > 0) CheckCuda(cudaMemsetAsync(memory, 0, bytes, Stream()), "cudaMemsetAsync");
}

void Copy(void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) CheckCuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, Stream()), "copy on the GPU");
}

void CopyFromHost(void* to, const void* from, std::size_t bytes) {
  if (bytes == 0) return;
  CheckCuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, Stream()), "copy to the GPU");
  Synchronize();
}

void CopyToHost(void* to, const void* from, std::size_t bytes) {
  if (bytes == 0) return;
  CheckCuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, Stream()), "copy from the GPU");
  Synchronize();
}

void Synchronize() {
  ++CountedHostWork().waits;
  CheckCuda(cudaStreamSynchronize(Stream()), "work on the GPU");
}

namespace {

void WaitFor(const LaggedReading& reading) {
  if (!reading.pending) return;
  ++CountedHostWork().waits;
  CheckCuda(cudaEventSynchronize(reading.arrived), "reading a scalar");
}

}  // namespace

double ReadLagged(const double* scalar) {
  Context& context = TheContext();
  auto& readings = context.readings;
  auto found = std::find_if(readings.begin(), readings.end(), [&](const auto& r) { return r.scalar == scalar; });
  if (found == readings.end()) {
    found = readings.begin() + static_cast<std::ptrdiff_t>(context.next_reading++ % kMaxReadings);
    WaitFor(*found);
    *found = {scalar, found->arrived, false};
  }
  double* landing = context.landing + (found - readings.begin());
  double value = 0;
  if (found->pending) {
    WaitFor(*found);
    value = *landing;
  }
  CheckCuda(cudaMemcpyAsync(landing, scalar, sizeof(double), cudaMemcpyDeviceToHost, context.stream),
            "reading a scalar");
  CheckCuda(cudaEventRecord(found->arrived, context.stream), "reading a scalar");
  found->pending = true;
  return value;
}

void DiscardLagged(const double* first, std::size_t count) {
  for (LaggedReading& reading : TheContext().readings) {
    if (reading.scalar < first || reading.scalar >= first + count) continue;
    WaitFor(reading);
    reading.scalar = nullptr;
    reading.pending = false;
  }
}

namespace {
std::vector<std::pair<const char*, const void*>>& Kernels() {
  static std::vector<std::pair<const char*, const void*>> kernels;
  return kernels;
}
}  // namespace

void RegisterKernel(const char* name, const void* kernel) { Kernels().emplace_back(name, kernel); }

std::vector<KernelStatistics> KernelTable() {
  std::vector<KernelStatistics> table;
  for (const auto& [name, kernel] : Kernels()) {
    cudaFuncAttributes attributes{};
    CheckCuda(cudaFuncGetAttributes(&attributes, kernel), name);
    table.push_back({name, attributes.numRegs, attributes.localSizeBytes, attributes.sharedSizeBytes});
  }
  return table;
}

std::size_t FreeBytes() {
  const Context& context = TheContext();
  std::uint64_t reserved = 0, used = 0;
  CheckCuda(cudaMemPoolGetAttribute(context.pool, cudaMemPoolAttrReservedMemCurrent, &reserved), "memory of the pool");
  CheckCuda(cudaMemPoolGetAttribute(context.pool, cudaMemPoolAttrUsedMemCurrent, &used), "memory of the pool");
  std::size_t left = 0, total = 0;
  CheckCuda(cudaMemGetInfo(&left, &total), "cudaMemGetInfo");
  return left + static_cast<std::size_t>(reserved - used);
}

std::size_t BytesInUse() { return TheContext().in_use; }
std::size_t PeakBytes() { return TheContext().peak; }
void ResetPeak() { TheContext().peak = TheContext().in_use; }

}  // namespace device

const DeviceInfo& QueryDevice() {
  static const DeviceInfo info = [] {
    DeviceInfo result;
    int count = 0;
    const cudaError_t status = cudaGetDeviceCount(&count);
    cudaDeviceProp properties{};
    if (status != cudaSuccess) {
      cudaGetLastError();
      result.name = cudaGetErrorString(status);
    } else if (count == 0) {
      result.name = "none was found";
    } else if (cudaSetDevice(kDevice) != cudaSuccess || cudaGetDeviceProperties(&properties, kDevice) != cudaSuccess) {
      result.name = cudaGetErrorString(cudaGetLastError());
    } else {
      result.name = properties.name;
      result.present = true;
      result.memory = properties.totalGlobalMem;
      result.multiprocessors = properties.multiProcessorCount;
      result.capability = 10 * properties.major + properties.minor;
      const std::string reason = device::UnsupportedReason();
      result.usable = reason.empty();
      if (!result.usable) result.name = device::NoCodeMessage(properties.name, result.capability, reason);
    }
    return result;
  }();
  return info;
}

}  // namespace vesta
