// How a view is shown in the joint problem: from the camera that was found, exposed, and bent by what its photograph is
// bent still.
#pragma once

#include <optional>

#include "problems/gaussian_splatting/cameras/bend_column.h"
#include "problems/gaussian_splatting/cameras/exposed_colors.h"
#include "problems/gaussian_splatting/cameras/joint_problem.h"
#include "problems/gaussian_splatting/cameras/moved_view.h"

namespace vesta::gs {

inline double CornerOf(const splat::PosedCamera& given) {
  return CornerOf(Camera{given.width, given.height, given.lens});
}
inline bool IsLens(const LensChange& change, const splat::PosedCamera& given) {
  return change.is_sound() && change.is_bend_sound(CornerOf(given));
}

// What view v's truth has been unbent by; none where no bend of it is found.
inline std::optional<RadialCoefficients> BendOf(const JointProblemOptions& options, const JointLayout& layout,
                                                Index v) {
  if (options.free.radial_tangent() == 0) return std::nullopt;
  return options.unbent_by[static_cast<std::size_t>(layout.views_before + v)];
}

// The derivative of what is shown by k1 (k = 0) or k2: how the photograph changes as it is bent. Of the photograph and
// not of what is rendered, so that what is shown is linear in the coefficients, and its derivative exact, as long as
// they are near to those it was unbent by.
template <class B>
void PhotographBend(const TargetView<B>& target, int k, typename B::View column) {
  BendColumn<B>(target, target.camera.lens, k, target.truth, column);
}

// image += coefficient(0) times that by k1 + coefficient(1) times that by k2.
template <class B, class Coefficient>
void AddBend(const Coefficient& coefficient, const TargetView<B>& target, JointScratch<B>& scratch,
             typename B::View image) {
  for (int k = 0; k < kRadialTangent; ++k) {
    const typename B::View column = scratch.Column(image.size());
    PhotographBend<B>(target, k, column);
    B().Axpby(coefficient(k), column, 1.0, image);
  }
}

// image, as rendered, becomes what is compared with the photograph.
template <class B>
void ShowAsFound(const ViewUnknowns& found, const std::optional<RadialCoefficients>& unbent_by,
                 const TargetView<B>& target, JointScratch<B>& scratch, typename B::View image) {
  Expose<B>(found.color, image);
  if (!unbent_by) return;
  AddBend<B>([&](int k) { return found.lens.radial[k] - (*unbent_by)[static_cast<std::size_t>(k)]; }, target, scratch,
             image);
}

}  // namespace vesta::gs
