// SPDX-License-Identifier: Apache-2.0
// Sums over images, in double, bit-identical for any number of threads.
#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/vector_backend.h"
#include "kernels/image/image_shape.h"

namespace vesta::gs {

inline constexpr Index kImageGrain = 1 << 15;  // pixels

// Sum of of(i) over i < n.
template <class Of>
double SumOver(Index n, const Of& of) {
  return ParallelSum<double>(n, kImageGrain, [&](Index begin, Index end) {
    double sum = 0;
    for (Index i = begin; i < end; ++i) sum += of(i);
    return sum;
  });
}

// A queue of sums over images in the memory of backend B. Read() returns all sums, so the host waits for a device only
// once. An image may be overwritten once its sum is queued.
template <class B>
class ImageProducts {
 public:
  using Space = typename B::Space;
  using ConstVectorView = typename B::ConstVectorView;

  // most: on a device, the maximum number of queued sums.
  explicit ImageProducts(int most) {
    if constexpr (kIsDevice) slots_.Resize(most);
  }
  // Queues a^T b. On a device both must have the scalar type of B.
  template <class T>
  void AddDot(ConstVectorView a, Span<const T, Space> b) {
    if constexpr (kIsDevice) {
      B().Dot(a, b, Next());
    } else {
      sums_.push_back(
          SumOver(a.size(), [&](Index i) { return static_cast<double>(a[i]) * static_cast<double>(b[i]); }));
    }
  }
  // Queues the sum of a.
  void AddSum(ConstVectorView a) {
    if constexpr (kIsDevice) {
      if (ones_.size() < a.size()) {
        ones_.ResizeForOverwrite(a.size());
        B().Fill(1, ones_);
      }
      AddDot(a, ConstVectorView(ones_.view()).subspan(0, a.size()));
    } else {
      sums_.push_back(SumOver(a.size(), [&](Index i) { return static_cast<double>(a[i]); }));
    }
  }
  // The sums in the order of the queue.
  std::vector<double> Read() {
    if constexpr (kIsDevice) {
      if (queued_ > 0) sums_ = B().Read(slots_);
      sums_.resize(static_cast<std::size_t>(queued_));
    }
    return std::move(sums_);
  }

 private:
  static constexpr bool kIsDevice = !std::is_same_v<Space, Host>;

  typename B::Slot Next() {
    VESTA_CHECK(queued_ < slots_.size(), "more than {} products", slots_.size());
    return B().SlotOf(slots_, queued_++);
  }

  std::vector<double> sums_;
  typename B::Slots slots_;
  typename B::Vector ones_;
  int queued_ = 0;
};

// Queues the gradient of an exposure: three gains, then three offsets. image: before the exposure. gradient: derivative
// of the cost with respect to the exposed image. Both have three planes.
template <class B>
void AddExposureProducts(typename B::ConstVectorView image, typename B::ConstVectorView gradient,
                         ImageProducts<B>& products) {
  const Index plane = image.size() / ImageShape::kChannels;
  const auto channel = [plane](typename B::ConstVectorView of, int c) { return of.subspan(c * plane, plane); };
  for (int c = 0; c < ImageShape::kChannels; ++c) products.AddDot(channel(image, c), channel(gradient, c));
  for (int c = 0; c < ImageShape::kChannels; ++c) products.AddSum(channel(gradient, c));
}

}  // namespace vesta::gs
