// What is found of a lens: its focal lengths, its principal point, and what is left of its radial distortion.
#pragma once

#include "kernels/gaussian_splatting/lens.h"
#include "kernels/gaussian_splatting/lens_jacobian.h"

namespace vesta::gs {

// From as it was given: focal lengths by factors exp(log_focal), the principal point by `shift`, in focal lengths as
// given; radial: k1 and k2 of the bend that the photograph still has (unbend.h). The same for the image at any size.
// Nothing by default.
struct LensChange {
  double log_focal[2] = {}, shift[2] = {}, radial[2] = {};

  bool operator==(const LensChange&) const = default;
  bool is_none() const { return *this == LensChange{}; }
  // Whether it is one that a lens could need: by less than a factor of e, and half a focal length.
  bool is_sound() const;
  // The same of the bend of an image whose farthest corner is so many focal lengths from the principal point: neither
  // coefficient moves the corner by half of its distance, and nothing folds.
  bool is_bend_sound(double corner) const;
  // The pinhole that was given as it is then, which the unbent photograph is of. By no change it keeps every bit.
  splat::Lens Of(const splat::Lens& given) const;
};

// A tangent of a lens: the pinhole's (splat::LensTangent), then of k1 and k2.
inline constexpr int kRadialTangent = 2, kLensNumbers = splat::kLensTangent + kRadialTangent;
struct LensStepNumbers {
  double v[kLensNumbers] = {};
};

// The retraction: the change, then that of the tangent at the lens as it is then. Two bends are one whose coefficients
// are their sums, to first order in the tangent where the change's are small.
LensChange Compose(const LensStepNumbers& delta, const LensChange& change);

}  // namespace vesta::gs
