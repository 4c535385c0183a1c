// Where the numbers of splats and views lie in a vector of the engine.
#pragma once

#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/cameras/view_unknowns.h"

namespace vesta::gs {

// x: first the splats' parameters, then for each view kViewParameters. A step: the splats', then those of each view
// that are free.
struct JointLayout {
  Index splats = 0;  // parameters of all Gaussians
  Index views = 0;
  FreeUnknowns free = {};
  // Of a part of a problem: x is that of the whole, which has so many more views before and after these.
  Index views_before = 0, views_after = 0;

  Index num_parameters() const { return PlaceOf(views + views_after); }
  Index num_tangent() const { return splats + views * free.num_tangent(); }

  // Of view v, in double.
  template <class S>
  ViewUnknowns UnknownsOf(HostSpan<const S> x, Index v) const {
    double numbers[kViewParameters];
    for (Index k = 0; k < kViewParameters; ++k) numbers[k] = static_cast<double>(x[PlaceOf(v) + k]);
    ViewUnknowns unknowns = Unpack({numbers, kViewParameters});
    // Of unit length in S is not so in double.
    NormalizeQuaternion(numbers, unknowns.motion.quaternion);
    return unknowns;
  }
  template <class S>
  void SetUnknowns(const ViewUnknowns& unknowns, Index v, HostSpan<S> x) const {
    double numbers[kViewParameters];
    Pack(unknowns, {numbers, kViewParameters});
    for (Index k = 0; k < kViewParameters; ++k) x[PlaceOf(v) + k] = static_cast<S>(numbers[k]);
  }
  // The part of a step, or of a gradient, that is view v's.
  template <class T>
  HostSpan<T> StepOf(HostSpan<T> step, Index v) const {
    return step.subspan(splats + v * free.num_tangent(), free.num_tangent());
  }

 private:
  // Of view v's numbers in x.
  Index PlaceOf(Index v) const { return splats + (views_before + v) * kViewParameters; }
};

}  // namespace vesta::gs
