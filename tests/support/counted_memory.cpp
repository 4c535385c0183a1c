// SPDX-License-Identifier: Apache-2.0
#include "tests/support/counted_memory.h"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<long> live_bytes{0}, most_bytes{0};

void* Counted(void* p) {
  if (p == nullptr) throw std::bad_alloc();
  const long live = live_bytes += static_cast<long>(malloc_usable_size(p));
  long most = most_bytes;
  while (most < live && !most_bytes.compare_exchange_weak(most, live)) {
  }
  return p;
}

void Release(void* p) {
  if (p != nullptr) live_bytes -= static_cast<long>(malloc_usable_size(p));
  std::free(p);
}

}  // namespace

void* operator new(std::size_t size) { return Counted(std::malloc(size == 0 ? 1 : size)); }
void* operator new(std::size_t size, std::align_val_t align) {
  const auto a = static_cast<std::size_t>(align);
  return Counted(std::aligned_alloc(a, (size + a) / a * a));
}
void operator delete(void* p) noexcept { Release(p); }
void operator delete(void* p, std::size_t) noexcept { Release(p); }
void operator delete(void* p, std::align_val_t) noexcept { Release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { Release(p); }

namespace vesta::test {

CountedMemory::CountedMemory() : before_(live_bytes) { most_bytes = before_; }

double CountedMemory::peak_bytes() const { return static_cast<double>(most_bytes - before_); }

}  // namespace vesta::test
