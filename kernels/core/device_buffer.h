// SPDX-License-Identifier: Apache-2.0
// Owning arrays in the memory of the GPU.
#pragma once

#include <algorithm>
#include <type_traits>
#include <utility>

#include "kernels/core/buffer.h"
#include "kernels/core/device_memory.h"

namespace vesta {

// Like the host's buffer: move-only, zero after construction and Resize, and its memory is reused. The host cannot
// access the elements; copies are explicit.
template <class T>
class Buffer<T, Device> {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  explicit Buffer(Index size) { Resize(size); }
  Buffer(Buffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ~Buffer() { device::Free(data_); }

  void Resize(Index size) {
    ResizeForOverwrite(size);
    device::SetZero(data_, Bytes());
  }
  // Discards the contents. On failure throws OutOfDeviceMemory and leaves the buffer empty.
  void ResizeForOverwrite(Index size) {
    if (size > capacity_) {
      device::Free(std::exchange(data_, nullptr));
      capacity_ = size_ = 0;
      data_ = static_cast<T*>(device::Allocate(static_cast<std::size_t>(size) * sizeof(T)));
      capacity_ = size;
    }
    size_ = size;
  }
  void CopyFrom(Span<const T, Host> other) {
    ResizeForOverwrite(other.size());
    device::CopyFromHost(data_, other.data(), Bytes());
  }
  void CopyFrom(Span<const T, Device> other) {
    ResizeForOverwrite(other.size());
    device::Copy(data_, other.data(), Bytes());
  }
  void CopyTo(Span<T, Host> other) const {
    device::CopyToHost(other.data(), data_, static_cast<std::size_t>(std::min(other.size(), size_)) * sizeof(T));
  }

  Index size() const { return size_; }
  Index capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  Span<T, Device> view() { return {data_, size_}; }
  Span<const T, Device> view() const { return {data_, size_}; }
  operator Span<T, Device>() { return view(); }
  operator Span<const T, Device>() const { return view(); }

 private:
  std::size_t Bytes() const { return static_cast<std::size_t>(size_) * sizeof(T); }

  T* data_ = nullptr;
  Index size_ = 0, capacity_ = 0;
};

template <class T>
using DeviceBuffer = Buffer<T, Device>;

}  // namespace vesta
