// Where the numbers of splats and views lie in a vector of the engine.
#pragma once

#include <cstddef>
#include <vector>

#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/cameras/view_unknowns.h"

namespace vesta::gs {

// x: first the splats' parameters, then for each view kViewParameters, its lens among them. A step: the splats', then
// each lens's, which views share, then those of each view that are free and its own. What comes after the splats' is
// the rest of either, which is little, and which the host works on wherever the splats are (joint_rest.h).
struct JointLayout {
  Index splats = 0;  // parameters of all Gaussians
  Index views = 0;
  FreeUnknowns free = {};
  // Where lenses are free: how many there are, and which of them each view of x has.
  Index lenses = 0;
  std::vector<std::size_t> lens_of = {};
  // Of a part of a problem: x is that of the whole, which has so many more views before and after these.
  Index views_before = 0, views_after = 0;

  Index num_parameters() const { return splats + PlaceOf(views + views_after); }
  FreeUnknowns own() const { return free.OwnOfView(); }
  // Entries of a step that are no view's own.
  Index shared() const { return splats + lenses * free.lens_tangent(); }
  Index num_tangent() const { return shared() + views * own().num_tangent(); }

  // Of a whole vector of the host.
  template <class T>
  HostSpan<T> RestOf(HostSpan<T> vector) const {
    return vector.subspan(splats, vector.size() - splats);
  }
  // Of view v, in double; rest: of x.
  template <class S>
  ViewUnknowns UnknownsOf(HostSpan<const S> rest, Index v) const {
    double numbers[kViewParameters];
    for (Index k = 0; k < kViewParameters; ++k) numbers[k] = static_cast<double>(rest[PlaceOf(v) + k]);
    ViewUnknowns unknowns = Unpack({numbers, kViewParameters});
    // Of unit length in S is not so in double.
    NormalizeQuaternion(numbers, unknowns.motion.quaternion);
    return unknowns;
  }
  template <class S>
  void SetUnknowns(const ViewUnknowns& unknowns, Index v, HostSpan<S> rest) const {
    double numbers[kViewParameters];
    Pack(unknowns, {numbers, kViewParameters});
    for (Index k = 0; k < kViewParameters; ++k) rest[PlaceOf(v) + k] = static_cast<S>(numbers[k]);
  }
  // The part of a step, or of a gradient, that is view v's; that is its lens's. rest: its own.
  template <class T>
  HostSpan<T> StepOf(HostSpan<T> rest, Index v) const {
    return rest.subspan(shared() - splats + v * own().num_tangent(), own().num_tangent());
  }
  template <class T>
  HostSpan<T> LensStepOf(HostSpan<T> rest, Index v) const {
    return rest.subspan(lenses > 0 ? LensOf(v) * free.lens_tangent() : 0, free.lens_tangent());
  }
  Index LensOf(Index v) const { return static_cast<Index>(lens_of[static_cast<std::size_t>(views_before + v)]); }
  // Both, as ViewUnknowns has a step.
  template <class T>
  std::vector<double> WholeStepOf(HostSpan<T> rest, Index v) const {
    const HostSpan<T> of_view = StepOf(rest, v), of_lens = LensStepOf(rest, v);
    std::vector<double> whole(of_view.begin(), of_view.end());
    whole.insert(whole.end(), of_lens.begin(), of_lens.end());
    return whole;
  }

 private:
  // Of view v's numbers in the rest of x.
  Index PlaceOf(Index v) const { return (views_before + v) * kViewParameters; }
};

}  // namespace vesta::gs
