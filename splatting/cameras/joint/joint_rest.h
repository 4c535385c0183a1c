// SPDX-License-Identifier: Apache-2.0
// The end of a vector of the engine, in the memory of the host: of a vector of the host its own, of a device's a copy.
#pragma once

#include <algorithm>
#include <type_traits>

#include "kernels/core/vector_backend.h"

namespace vesta::gs {

// From `begin` on, to look at. Of a device's vector it is as it was then, and was waited for.
template <class B>
class ConstRest {
 public:
  ConstRest(typename B::ConstVectorView vector, Index begin) {
    const typename B::ConstVectorView there = vector.subspan(begin, vector.size() - begin);
    if constexpr (std::is_same_v<typename B::Space, Host>) {
      here_ = there;
    } else if (there.size() > 0) {
      copy_.ResizeForOverwrite(there.size());
      B().ToHost(there, copy_);
      here_ = copy_.view();
    }
  }
  HostSpan<const typename B::Scalar> view() const { return here_; }

 private:
  HostBuffer<typename B::Scalar> copy_;
  HostSpan<const typename B::Scalar> here_;
};

struct FromZero {};

// To look at and to write to. What was written is sure to be in the vector once it was stored.
template <class B>
class Rest {
 public:
  Rest(typename B::VectorView vector, Index begin) : there_(vector.subspan(begin, vector.size() - begin)) {
    if constexpr (kIsHost) {
      here_ = there_;
    } else if (there_.size() > 0) {
      copy_.ResizeForOverwrite(there_.size());
      B().ToHost(there_, copy_);
      here_ = copy_.view();
    }
  }
  // Begins with zeros, whatever the vector has.
  Rest(FromZero, typename B::VectorView vector, Index begin) : there_(vector.subspan(begin, vector.size() - begin)) {
    if constexpr (kIsHost) {
      here_ = there_;
      std::fill(here_.begin(), here_.end(), typename B::Scalar(0));
    } else {
      copy_.Resize(there_.size());
      here_ = copy_.view();
    }
  }
  HostSpan<typename B::Scalar> view() { return here_; }
  void Store() {
    if constexpr (!kIsHost) {
      if (there_.size() > 0) B().FromHost(here_, there_);
    }
  }

 private:
  static constexpr bool kIsHost = std::is_same_v<typename B::Space, Host>;

  typename B::VectorView there_;
  HostBuffer<typename B::Scalar> copy_;
  HostSpan<typename B::Scalar> here_;
};

}  // namespace vesta::gs
