// SPDX-License-Identifier: Apache-2.0
// Where the numbers of splats and views lie in a vector of the engine, and access to those of the views.
#pragma once

#include <algorithm>
#include <type_traits>

#include "kernels/core/vector_backend.h"
#include "kernels/math/quaternion.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// x: first the splats' parameters, then for each view kViewParameters. A step: the splats', then those of each view
// that are free. What comes after the splats' is the rest of either, which is little, and which the host works on
// wherever the splats are (ConstRest).
struct JointLayout {
  Index splats = 0;  // parameters of all Gaussians
  Index views = 0;
  FreeUnknowns free = {};

  Index num_parameters() const { return splats + views * kViewParameters; }
  Index num_tangent() const { return splats + views * free.num_tangent(); }

  // Of a whole vector of the host.
  template <class T>
  HostSpan<T> RestOf(HostSpan<T> vector) const {
    return vector.subspan(splats, vector.size() - splats);
  }
  // Of view v, in double; rest: of x.
  template <class S>
  ViewUnknowns UnknownsOf(HostSpan<const S> rest, Index v) const {
    double numbers[kViewParameters];
    for (Index k = 0; k < kViewParameters; ++k) numbers[k] = static_cast<double>(rest[v * kViewParameters + k]);
    ViewUnknowns unknowns = Unpack({numbers, kViewParameters});
    // Of unit length in S is not so in double.
    NormalizeQuaternion(numbers, unknowns.motion.quaternion);
    return unknowns;
  }
  template <class S>
  void SetUnknowns(const ViewUnknowns& unknowns, Index v, HostSpan<S> rest) const {
    double numbers[kViewParameters];
    Pack(unknowns, {numbers, kViewParameters});
    for (Index k = 0; k < kViewParameters; ++k) rest[v * kViewParameters + k] = static_cast<S>(numbers[k]);
  }
  // The part of a step, or of a gradient, that is view v's. rest: its own.
  template <class T>
  HostSpan<T> StepOf(HostSpan<T> rest, Index v) const {
    return rest.subspan(v * free.num_tangent(), free.num_tangent());
  }
};

// The end of a vector of the engine, in the memory of the host: of a vector of the host its own, of a device's a copy.
// This one is to look at, from `begin` on. Of a device's vector it is as it was then, and was waited for.
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
