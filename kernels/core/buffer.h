// SPDX-License-Identifier: Apache-2.0
// Owning arrays in a memory space.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>

#include "kernels/core/huge_pages.h"
#include "kernels/core/span.h"

namespace vesta {

template <class T, class Space>
class Buffer;

// Memory aligned to 64 bytes. It comes from plain operator new, because glibc does not take
// aligned blocks from its cache of small blocks.
inline void* AllocateAligned(std::size_t bytes) {
  constexpr std::size_t kAlignment = 64;
  auto* const start = static_cast<std::byte*>(::operator new(bytes + kAlignment));
  AdviseHugePages(start, bytes);
  // The distance, 1 to 64, is stored in the byte before the result.
  const std::size_t distance = kAlignment - reinterpret_cast<std::uintptr_t>(start) % kAlignment;
  start[distance - 1] = static_cast<std::byte>(distance);
  return start + distance;
}
inline void FreeAligned(void* memory) noexcept {
  auto* const aligned = static_cast<std::byte*>(memory);
  ::operator delete(aligned - static_cast<std::size_t>(aligned[-1]));
}

// Host array of trivially copyable elements, aligned to 64 bytes. Move-only; CopyFrom copies. Elements are zero after
// construction and Resize.
template <class T>
class Buffer<T, Host> {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  explicit Buffer(Index size) { Resize(size); }
  Buffer(Buffer&& other) noexcept
      : data_(std::move(other.data_)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    data_ = std::move(other.data_);
    size_ = std::exchange(other.size_, 0);
    capacity_ = std::exchange(other.capacity_, 0);
    return *this;
  }

  // Discards the contents and sets all elements to T{}. Like the functions below, reuses the memory if it is large
  // enough.
  void Resize(Index size) {
    ResizeForOverwrite(size);
    std::fill_n(data_.get(), size_, T{});
  }
  // Discards the contents; the elements are uninitialised.
  void ResizeForOverwrite(Index size) {
    if (size > capacity_) {
      data_.reset();
      capacity_ = size_ = 0;
      data_.reset(static_cast<T*>(AllocateAligned(static_cast<std::size_t>(size) * sizeof(T))));
      capacity_ = size;
    }
    size_ = size;
  }
  void CopyFrom(Span<const T, Host> other) {
    ResizeForOverwrite(other.size());
    std::copy_n(other.data(), size_, data_.get());
  }

  Index size() const { return size_; }
  // Number of elements that fit into the allocation.
  Index capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](Index i) { return data_.get()[i]; }
  const T& operator[](Index i) const { return data_.get()[i]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  Span<T, Host> view() { return {data(), size_}; }
  Span<const T, Host> view() const { return {data(), size_}; }
  operator Span<T, Host>() { return view(); }
  operator Span<const T, Host>() const { return view(); }

 private:
  struct Free {
    void operator()(T* p) const { FreeAligned(p); }
  };
  std::unique_ptr<T, Free> data_;
  Index size_ = 0, capacity_ = 0;
};

template <class T>
using HostBuffer = Buffer<T, Host>;

}  // namespace vesta
