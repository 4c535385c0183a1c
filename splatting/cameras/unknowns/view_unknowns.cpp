#include "splatting/cameras/unknowns/view_unknowns.h"

#include <algorithm>

#include "kernels/core/check.h"

namespace vesta::gs {

void Pack(const ViewUnknowns& unknowns, HostSpan<double> x) {
  VESTA_CHECK(x.size() == kViewParameters, "{} values for the {} of a view", x.size(), kViewParameters);
  double* out = std::copy_n(unknowns.motion.quaternion, 4, x.data());
  out = std::copy_n(unknowns.motion.translation, 3, out);
  out = std::copy_n(unknowns.color.gain.data(), 3, out);
  std::copy_n(unknowns.color.offset.data(), 3, out);
}

ViewUnknowns Unpack(HostSpan<const double> x) {
  VESTA_CHECK(x.size() == kViewParameters, "{} values for the {} of a view", x.size(), kViewParameters);
  ViewUnknowns unknowns;
  std::copy_n(x.data(), 4, unknowns.motion.quaternion);
  std::copy_n(x.data() + 4, 3, unknowns.motion.translation);
  std::copy_n(x.data() + 7, 3, unknowns.color.gain.data());
  std::copy_n(x.data() + 10, 3, unknowns.color.offset.data());
  return unknowns;
}

ViewUnknowns Plus(const ViewUnknowns& unknowns, const FreeUnknowns& free, HostSpan<const double> delta) {
  VESTA_CHECK(delta.size() == free.num_tangent(), "a step of {} numbers, want {}", delta.size(), free.num_tangent());
  ViewUnknowns moved = unknowns;
  if (free.pose) {
    splat::PoseTangent xi;
    std::copy_n(delta.data(), splat::kPoseTangent, xi.v);
    moved.motion = splat::Compose(xi, unknowns.motion);
  }
  if (free.color) {
    for (int c = 0; c < ImageShape::kChannels; ++c) {
      moved.color.gain[static_cast<std::size_t>(c)] += delta[free.Gain(c)];
      moved.color.offset[static_cast<std::size_t>(c)] += delta[free.Offset(c)];
    }
  }
  if (free.lens) {
    splat::LensTangent step;
    std::copy_n(delta.data() + free.Lens(0), free.lens_tangent(), step.v);
    moved.lens = Compose(step, unknowns.lens);
  }
  return moved;
}

}  // namespace vesta::gs
