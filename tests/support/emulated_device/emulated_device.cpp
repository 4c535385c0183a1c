// A GPU made of the host: the bodies of kernels/core that DeviceView, the loss and the splatting problem need. Memory
// is the host's, and all ones when allocated, so that what is read before it is written is NaN.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>
#include <numeric>

#include "kernels/core/block_diagonal.inl"
#include "kernels/core/cuda_backend.h"
#include "kernels/core/device_sort.h"
#include "solver/problem.inl"

namespace vesta {

const DeviceInfo& QueryDevice() {
  static const DeviceInfo info{.usable = true, .name = "emulated"};
  return info;
}

namespace device {

void* Allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  void* memory = std::malloc(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return std::memset(memory, 0xff, bytes);
}
void Free(void* memory) noexcept { std::free(memory); }
void SetZero(void* memory, std::size_t bytes) {
  if (bytes > 0) std::memset(memory, 0, bytes);
}
void Copy(void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) std::memcpy(to, from, bytes);
}
void CopyFromHost(void* to, const void* from, std::size_t bytes) { Copy(to, from, bytes); }
void CopyToHost(void* to, const void* from, std::size_t bytes) { Copy(to, from, bytes); }

void SortPairs(DeviceBuffer<std::uint32_t>& keys, DeviceBuffer<std::uint32_t>& values,
               DeviceBuffer<std::uint32_t>& other_keys, DeviceBuffer<std::uint32_t>& other_values, Index count,
               int bits, DeviceBuffer<unsigned char>&) {
  std::vector<Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), Index{0});
  const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return (keys.data()[a] & mask) < (keys.data()[b] & mask); });
  for (Index k = 0; k < count; ++k) {
    other_keys.data()[k] = keys.data()[order[static_cast<std::size_t>(k)]];
    other_values.data()[k] = values.data()[order[static_cast<std::size_t>(k)]];
  }
  std::swap(keys, other_keys);
  std::swap(values, other_values);
}

void RunningSum(const Index* counts, Index* sums, Index size, DeviceBuffer<unsigned char>&) {
  std::exclusive_scan(counts, counts + size, sums, Index{0});
}

}  // namespace device

namespace {

template <class T>
HostSpan<T> OnHost(Span<T, Device> v) {
  return {v.data(), v.size()};
}

}  // namespace

template <>
void VectorBackend<float, Device>::Fill(double a, View y) {
  CpuBackend<float>().Fill(a, OnHost(y));
}
template <>
void VectorBackend<float, Device>::Copy(ConstView x, View y) {
  CpuBackend<float>().Copy(OnHost(x), OnHost(y));
}
template <>
void VectorBackend<float, Device>::Axpby(double a, ConstView x, double b, View y) {
  CpuBackend<float>().Axpby(a, OnHost(x), b, OnHost(y));
}
template <>
void VectorBackend<float, Device>::Multiply(ConstView d, ConstView x, View y) {
  CpuBackend<float>().Multiply(OnHost(d), OnHost(x), OnHost(y));
}
template <>
double VectorBackend<float, Device>::Dot(ConstView x, ConstView y) {
  return CpuBackend<float>().Dot(OnHost(x), OnHost(y));
}
template <>
void VectorBackend<float, Device>::FromHost(HostSpan<const float> x, View y) {
  CpuBackend<float>().Copy(x, OnHost(y));
}
template <>
void VectorBackend<float, Device>::ToHost(ConstView x, HostSpan<float> y) {
  CpuBackend<float>().Copy(OnHost(x), y);
}

template class BlockDiagonal<CudaBackend<float>>;
template class Linearization<CudaBackend<float>>;
template class Problem<CudaBackend<float>>;

}  // namespace vesta
