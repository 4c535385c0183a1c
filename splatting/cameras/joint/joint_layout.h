// SPDX-License-Identifier: Apache-2.0
// Layout of the parameter vector for joint optimisation of Gaussians ("splats") and views. Host access to the views'
// part.
#pragma once

#include <algorithm>
#include <type_traits>

#include "kernels/core/vector_backend.h"
#include "kernels/math/quaternion.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// x has the parameters of all Gaussians, then kViewParameters numbers per view (view_unknowns.h). A step, or a
// gradient, has a number per Gaussian parameter, then free.num_tangent() numbers per view. The views' part is called
// the rest. It is small, so the host computes it even if the Gaussians are on a device (ConstHostTail, HostTail).
struct JointLayout {
  Index splats = 0;  // parameters of all Gaussians
  Index views = 0;
  FreeUnknowns free = {};

  Index num_parameters() const { return splats + views * kViewParameters; }
  Index num_tangent() const { return splats + views * free.num_tangent(); }

  // The rest of a vector in host memory.
  template <class T>
  HostSpan<T> RestOf(HostSpan<T> vector) const {
    return vector.subspan(splats, vector.size() - splats);
  }
  // The unknowns of view v. rest: the rest of x.
  template <class S>
  ViewUnknowns UnknownsOf(HostSpan<const S> rest, Index v) const {
    double numbers[kViewParameters];
    for (Index k = 0; k < kViewParameters; ++k) numbers[k] = static_cast<double>(rest[v * kViewParameters + k]);
    ViewUnknowns unknowns = Unpack({numbers, kViewParameters});
    // Rounding to S changed the length of the quaternion.
    NormalizeQuaternion(numbers, unknowns.motion.quaternion);
    return unknowns;
  }
  template <class S>
  void SetUnknowns(const ViewUnknowns& unknowns, Index v, HostSpan<S> rest) const {
    double numbers[kViewParameters];
    Pack(unknowns, {numbers, kViewParameters});
    for (Index k = 0; k < kViewParameters; ++k) rest[v * kViewParameters + k] = static_cast<S>(numbers[k]);
  }
  // View v in the rest of a step or gradient.
  template <class T>
  HostSpan<T> StepOf(HostSpan<T> rest, Index v) const {
    return rest.subspan(v * free.num_tangent(), free.num_tangent());
  }
};

// Host access to the elements from index `begin` on of a vector of backend B. In host memory, it is a reference; from a
// device, the constructor copies the elements and waits.
template <class B>
class ConstHostTail {
 public:
  ConstHostTail(typename B::ConstVectorView vector, Index begin) {
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

struct ZeroInitialized {};

// The same with write access. For a device vector, Store() copies the changes back.
template <class B>
class HostTail {
 public:
  HostTail(typename B::VectorView vector, Index begin) : there_(vector.subspan(begin, vector.size() - begin)) {
    if constexpr (kIsHost) {
      here_ = there_;
    } else if (there_.size() > 0) {
      copy_.ResizeForOverwrite(there_.size());
      B().ToHost(there_, copy_);
      here_ = copy_.view();
    }
  }
  // Starts with zeros instead of reading the vector.
  HostTail(ZeroInitialized, typename B::VectorView vector, Index begin)
      : there_(vector.subspan(begin, vector.size() - begin)) {
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
