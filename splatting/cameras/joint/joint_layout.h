// SPDX-License-Identifier: Apache-2.0
// Where the numbers of splats and views lie in a vector of the engine.
#pragma once

#include "kernels/math/quaternion.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// x: first the splats' parameters, then for each view kViewParameters. A step: the splats', then those of each view
// that are free. What comes after the splats' is the rest of either, which is little, and which the host works on
// wherever the splats are (joint_rest.h).
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

}  // namespace vesta::gs
