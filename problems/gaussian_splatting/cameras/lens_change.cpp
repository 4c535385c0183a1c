#include "problems/gaussian_splatting/cameras/lens_change.h"

#include <cmath>

namespace vesta::gs {

bool LensChange::is_sound() const {
  const auto is_within = [](const double v[2], double most) { return std::abs(v[0]) < most && std::abs(v[1]) < most; };
  return is_within(log_focal, 1) && is_within(shift, 0.5);
}

bool LensChange::is_bend_sound(double corner) const {
  const double r2 = corner * corner, k1 = radial[0] * r2, k2 = radial[1] * r2 * r2;  // at the corner
  // Of so small ones the slope, 1 + 3 k1 t + 5 k2 t^2 at t = (r / corner)^2, is positive everywhere if it is at t = 1.
  return std::abs(k1) < 0.5 && std::abs(k2) < 0.5 && 1 + 3 * k1 + 5 * k2 > 0;
}

splat::Lens LensChange::Of(const splat::Lens& given) const {
  return {given.fx * std::exp(log_focal[0]), given.fy * std::exp(log_focal[1]), given.cx + given.fx * shift[0],
          given.cy + given.fy * shift[1]};
}

LensChange Compose(const LensStepNumbers& delta, const LensChange& change) {
  LensChange composed = change;
  for (int k = 0; k < 2; ++k) {
    composed.shift[k] += std::exp(change.log_focal[k]) * delta.v[2 + k];
    composed.log_focal[k] += delta.v[k];
    composed.radial[k] += delta.v[splat::kLensTangent + k];
  }
  return composed;
}

}  // namespace vesta::gs
