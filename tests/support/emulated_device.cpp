// SPDX-License-Identifier: Apache-2.0
// Implements device_memory.h and device_sort.h on the host.
#include "tests/support/emulated_device.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/device_kernels.h"
#include "kernels/core/device_memory.h"
#include "kernels/core/device_sort.h"

namespace vesta {
namespace {

struct Memory {
  std::map<void*, std::size_t> sizes;
  std::size_t total = test::kAmpleDeviceMemory, in_use = 0, peak = 0;
};
// One per thread, as processes may have their own. Never destroyed, because static buffers are freed later.
Memory& NewMemory() {
  static std::mutex mutex;
  static auto* all = new std::deque<Memory>;
  const std::lock_guard lock(mutex);
  return all->emplace_back();
}
Memory& TheMemory() {
  thread_local Memory& memory = NewMemory();
  return memory;
}

}  // namespace

void test::SetDeviceMemory(std::size_t bytes) { TheMemory().total = bytes; }

namespace {

constexpr int kCapability = 75;
struct Launches {
  int skipped = 0, failing = 0, trims = 0;
};
thread_local Launches launches;
DeviceInfo& Emulated() {
  thread_local DeviceInfo info{.present = true,
                               .usable = true,
                               .name = "emulated",
                               .memory = test::kAmpleDeviceMemory,
                               .multiprocessors = 1,
                               .capability = kCapability};
  return info;
}

}  // namespace

void test::FailLaunches(int skipped, int attempts) { launches.skipped = skipped, launches.failing = attempts; }
bool test::LaunchFindsMemory() {
  if (launches.failing == 0 || launches.skipped-- > 0) return true;
  launches.skipped = 0;
  --launches.failing;
  return false;
}
int test::NumTrims() { return launches.trims; }

test::WithoutDeviceCode::WithoutDeviceCode() {
  Emulated().usable = false;
  Emulated().name = device::NoCodeMessage("an emulated GPU", kCapability, "no kernel image is available");
}
test::WithoutDeviceCode::~WithoutDeviceCode() { Emulated().usable = true, Emulated().name = "emulated"; }

const DeviceInfo& QueryDevice() { return Emulated(); }

namespace device {

void* Allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  Memory& memory = TheMemory();
  if (memory.in_use + bytes > memory.total) {
    throw OutOfDeviceMemory(
        fmt::format("cannot allocate {} bytes on the GPU: {} of {} are in use", bytes, memory.in_use, memory.total));
  }
  void* p = ::operator new (bytes, std::align_val_t{256});
  std::memset(p, 0xff, bytes);  // NaNs
  memory.sizes[p] = bytes;
  memory.in_use += bytes;
  memory.peak = std::max(memory.peak, memory.in_use);
  return p;
}

void Free(void* p) noexcept {
  if (p == nullptr) return;
  Memory& memory = TheMemory();
  const auto found = memory.sizes.find(p);
  memory.in_use -= found->second;
  memory.sizes.erase(found);
  ::operator delete (p, std::align_val_t{256});
}

void TrimPool() {
  Synchronize();
  ++launches.trims;
}

void SetZero(void* memory, std::size_t bytes) {
  if (bytes > 0) std::memset(memory, 0, bytes);
}
void Copy(void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) std::memmove(to, from, bytes);
}
void CopyFromHost(void* to, const void* from, std::size_t bytes) {
  Copy(to, from, bytes);
  if (bytes > 0) Synchronize();
}
void CopyToHost(void* to, const void* from, std::size_t bytes) { CopyFromHost(to, from, bytes); }
void Synchronize() { ++CountedHostWork().waits; }
std::vector<KernelStatistics> KernelTable() { return {}; }

namespace {
// Seen by the last call, per scalar: the maximal delay of a real device.
std::map<const double*, double>& Readings() {
  thread_local std::map<const double*, double> readings;
  return readings;
}
}  // namespace

double ReadLagged(const double* scalar) { return std::exchange(Readings()[scalar], *scalar); }
void DiscardLagged(const double* first, std::size_t count) {
  Readings().erase(Readings().lower_bound(first), Readings().lower_bound(first + count));
}

std::size_t FreeBytes() { return TheMemory().total - std::min(TheMemory().total, TheMemory().in_use); }
std::size_t BytesInUse() { return TheMemory().in_use; }
std::size_t PeakBytes() { return TheMemory().peak; }
void ResetPeak() { TheMemory().peak = TheMemory().in_use; }

void SortPairs(DeviceBuffer<std::uint32_t>& keys, DeviceBuffer<std::uint32_t>& values,
               DeviceBuffer<std::uint32_t>& other_keys, DeviceBuffer<std::uint32_t>& other_values, Index count,
               int bits, DeviceBuffer<unsigned char>& /*temporary*/) {
  if (count == 0) return;
  ++CountedHostWork().launches;
  const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
  std::vector<Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return (keys.data()[a] & mask) < (keys.data()[b] & mask); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    other_keys.data()[i] = keys.data()[order[i]];
    other_values.data()[i] = values.data()[order[i]];
  }
  std::swap(keys, other_keys);
  std::swap(values, other_values);
}

void RunningSum(const Index* counts, Index* sums, Index size, DeviceBuffer<unsigned char>& /*temporary*/) {
  if (size == 0) return;
  ++CountedHostWork().launches;
  std::exclusive_scan(counts, counts + size, sums, Index{0});
}

}  // namespace device
}  // namespace vesta
