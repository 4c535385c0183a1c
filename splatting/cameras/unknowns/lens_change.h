// What is found of a lens: its focal lengths and its principal point.
#pragma once

#include "kernels/gaussian_splatting/formulas/lens.h"
#include "kernels/gaussian_splatting/projection/lens_motion.h"

namespace vesta::gs {

// From as it was given: focal lengths by factors exp(log_focal), the principal point by `shift`, in focal lengths as
// given. The same for the image at any size. Nothing by default.
struct LensChange {
  double log_focal[2] = {}, shift[2] = {};

  bool operator==(const LensChange&) const = default;
  bool is_none() const { return *this == LensChange{}; }
  // Whether it is one that a lens could need: by less than a factor of e, and half a focal length.
  bool is_sound() const;
  // The pinhole that was given as it is then. By no change it keeps every bit.
  splat::Lens Of(const splat::Lens& given) const;
};

// The retraction: the change, then that of the tangent at the lens as it is then.
LensChange Compose(const splat::LensTangent& delta, const LensChange& change);

}  // namespace vesta::gs
