// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/unknowns/view_unknowns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/check.h"
#include "kernels/core/vector_backend.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/exposed_colors.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::gs {

AffineColor AffineColor::Inverse() const {
  AffineColor inverse;
  for (std::size_t c = 0; c < gain.size(); ++c) {
    inverse.gain[c] = 1 / gain[c];
    inverse.offset[c] = -offset[c] / gain[c];
  }
  return inverse;
}

AffineColor AffineColor::After(const AffineColor& first) const {
  AffineColor both;
  for (std::size_t c = 0; c < gain.size(); ++c) {
    both.gain[c] = gain[c] * first.gain[c];
    both.offset[c] = gain[c] * first.offset[c] + offset[c];
  }
  return both;
}

template <class S>
void AffineColor::Apply(HostSpan<S> image) const {
  Expose<CpuBackend<S>>(*this, image);
}
template void AffineColor::Apply(HostSpan<float> image) const;
template void AffineColor::Apply(HostSpan<double> image) const;

bool LensChange::is_sound() const {
  const auto is_within = [](const double v[2], double most) { return std::abs(v[0]) < most && std::abs(v[1]) < most; };
  return is_within(log_focal, 1) && is_within(shift, 0.5);
}

splat::Lens LensChange::Of(const splat::Lens& given) const {
  return {given.fx * std::exp(log_focal[0]), given.fy * std::exp(log_focal[1]), given.cx + given.fx * shift[0],
          given.cy + given.fy * shift[1], given.model};
}

LensChange Compose(const splat::LensTangent& delta, const LensChange& change) {
  LensChange composed = change;
  for (int k = 0; k < 2; ++k) {
    composed.shift[k] += std::exp(change.log_focal[k]) * delta.v[2 + k];
    composed.log_focal[k] += delta.v[k];
  }
  return composed;
}

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

CameraChanges ChangesOf(const SplatModel& model, const std::vector<const View*>& given,
                        const std::vector<ViewUnknowns>& found, double near) {
  VESTA_CHECK(given.size() == found.size(), "{} given views, but {} found ones", given.size(), found.size());
  CameraChanges changes;
  std::vector<double> degrees, pixels;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const splat::CameraMotion& motion = found[i].motion;
    degrees.push_back(motion.Angle() * 180 / std::numbers::pi);
    // Usually most cameras have not moved: skip their projection.
    const bool is_still = degrees.back() == 0 && found[i].lens.is_none() &&
                          std::ranges::all_of(motion.translation, [](double t) { return t == 0; });
    pixels.push_back(is_still ? 0 : MedianShift(model, *given[i], AsFound(*given[i], found[i]), near));
    changes.most_pixels = std::max(changes.most_pixels, pixels.back());
    for (const double log_focal : found[i].lens.log_focal) {
      changes.most_focal = std::max(changes.most_focal, std::abs(std::exp(log_focal) - 1));
    }
    for (const double gain : found[i].color.gain) changes.most_gain = std::max(changes.most_gain, std::abs(gain - 1));
  }
  if (given.empty()) return changes;
  changes.degrees = Median(std::move(degrees));
  changes.pixels = Median(std::move(pixels));
  return changes;
}

const schema::Table<CameraOptions>& CameraFields() {
  using O = CameraOptions;
  static const schema::Table<O> fields = {
      {"refine", &O::refine, kCameraChoices,
       "camera parameters of the training views to optimise during training; exposure: a gain and an offset per image "
       "and "
       "channel; all: also focal lengths and principal points; auto: poses, if that improves training views held out "
       "at "
       "first",
       "refine_cameras"},
  };
  return fields;
}

FreeUnknowns FreeBy(CameraChoice choice) {
  FreeUnknowns free;
  free.lens = choice == CameraChoice::kAll;
  free.color = free.lens || choice == CameraChoice::kPoseAndExposure;
  free.pose = free.color || choice == CameraChoice::kPose;
  return free;
}

}  // namespace vesta::gs
