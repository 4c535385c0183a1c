// SPDX-License-Identifier: Apache-2.0
// Memory spaces and views. The space is part of the type, so host code cannot receive a device pointer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "kernels/core/hd.h"

namespace vesta {

// A count or a position. Signed, as in Eigen and Ceres.
using Index = std::int64_t;

struct Host {};
struct Device {};

// A non-owning view of `size` contiguous elements in memory space Space. Cheap to copy.
template <class T, class Space>
class Span {
 public:
  VESTA_HD constexpr Span() = default;
  VESTA_HD constexpr Span(T* data, Index size) : data_(data), size_(size) {}
  // A mutable view converts to a constant one. Memory spaces never convert.
  template <class U, class = std::enable_if_t<std::is_convertible_v<U (*)[], T (*)[]>>>
  VESTA_HD constexpr Span(Span<U, Space> other) : data_(other.data()), size_(other.size()) {}

  VESTA_HD constexpr T* data() const { return data_; }
  VESTA_HD constexpr Index size() const { return size_; }
  VESTA_HD constexpr bool empty() const { return size_ == 0; }
  VESTA_HD constexpr T& operator[](Index i) const { return data_[i]; }
  VESTA_HD constexpr T* begin() const { return data_; }
  VESTA_HD constexpr T* end() const { return data_ + size_; }
  VESTA_HD constexpr Span subspan(Index offset, Index count) const { return Span(data_ + offset, count); }

 private:
  T* data_ = nullptr;
  Index size_ = 0;
};

template <class T>
using HostSpan = Span<T, Host>;

}  // namespace vesta
