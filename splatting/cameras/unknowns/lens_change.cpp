#include "splatting/cameras/unknowns/lens_change.h"

#include <cmath>

namespace vesta::gs {

bool LensChange::is_sound() const {
  const auto is_within = [](const double v[2], double most) { return std::abs(v[0]) < most && std::abs(v[1]) < most; };
  return is_within(log_focal, 1) && is_within(shift, 0.5);
}

splat::Lens LensChange::Of(const splat::Lens& given) const {
  return {given.fx * std::exp(log_focal[0]), given.fy * std::exp(log_focal[1]), given.cx + given.fx * shift[0],
          given.cy + given.fy * shift[1]};
}

LensChange Compose(const splat::LensTangent& delta, const LensChange& change) {
  LensChange composed = change;
  for (int k = 0; k < 2; ++k) {
    composed.shift[k] += std::exp(change.log_focal[k]) * delta.v[2 + k];
    composed.log_focal[k] += delta.v[k];
  }
  return composed;
}

}  // namespace vesta::gs
