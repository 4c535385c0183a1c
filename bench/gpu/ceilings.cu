// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "bench/gpu/ceilings.h"
#include "kernels/core/device_buffer.h"
#include "kernels/core/launch.cuh"

namespace vesta::bench {
namespace {

constexpr int kChains = 8, kSteps = 4096;

struct MultiplyAddChains {
  float* out;
  __device__ void operator()(Index i) const {
    float x[kChains];
    for (int c = 0; c < kChains; ++c) x[c] = 1e-3f * static_cast<float>(i % 1024 + c);
    for (int step = 0; step < kSteps; ++step) {
#pragma unroll
      for (int c = 0; c < kChains; ++c) x[c] = __fmaf_rn(x[c], 0.999f, 1e-3f);
    }
    float sum = 0;
    for (int c = 0; c < kChains; ++c) sum += x[c];
    out[i] = sum;
  }
};

}  // namespace

double DeviceMilliseconds(int repeats, const std::function<void()>& body) {
  using device::CheckCuda;
  cudaEvent_t begin = nullptr, end = nullptr;
  CheckCuda(cudaEventCreate(&begin), "cudaEventCreate");
  CheckCuda(cudaEventCreate(&end), "cudaEventCreate");
  body();
  std::vector<float> times(static_cast<std::size_t>(repeats));
  for (float& time : times) {
    CheckCuda(cudaEventRecord(begin, device::Stream()), "cudaEventRecord");
    body();
    CheckCuda(cudaEventRecord(end, device::Stream()), "cudaEventRecord");
    CheckCuda(cudaEventSynchronize(end), "cudaEventSynchronize");
    CheckCuda(cudaEventElapsedTime(&time, begin, end), "cudaEventElapsedTime");
  }
  CheckCuda(cudaEventDestroy(begin), "cudaEventDestroy");
  CheckCuda(cudaEventDestroy(end), "cudaEventDestroy");
  std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
  return times[static_cast<std::size_t>(repeats / 2)];
}

double CopyBytesPerSecond() {
  const Index size = Index{1} << 29;  // far beyond any cache
  DeviceBuffer<float> from(size), to(size);
  const double bytes = 2.0 * static_cast<double>(size) * sizeof(float);
  return bytes / (1e-3 * DeviceMilliseconds(10, [&] { to.CopyFrom(from.view()); }));
}

double FlopsPerSecond() {
  const Index threads = Index{QueryDevice().multiprocessors} * 2048 * 4;
  DeviceBuffer<float> out(threads);
  const double ms = DeviceMilliseconds(
      10, [&] { device::ForEach(threads, MultiplyAddChains{out.data()}, "ceiling of multiply-adds"); });
  return 2.0 * kChains * kSteps * static_cast<double>(threads) / (1e-3 * ms);
}

}  // namespace vesta::bench
