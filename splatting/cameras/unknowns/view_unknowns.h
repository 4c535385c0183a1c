// SPDX-License-Identifier: Apache-2.0
// The unknowns of a view (pose, lens and exposure), and the option that selects which of them a training optimises.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/schema.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/lenses/lens.h"
#include "kernels/gaussian_splatting/projection/camera_motion.h"
#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "kernels/image/image_shape.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// An exposure: maps a value of channel c to gain[c] * value + offset[c]. Values are as stored in the image file, 0 to
// 1. The default is the identity.
struct AffineColor {
  std::array<double, 3> gain{1, 1, 1}, offset{};

  bool operator==(const AffineColor&) const = default;
  bool is_none() const { return *this == AffineColor{}; }
  // The inverse map. No gain may be 0.
  AffineColor Inverse() const;
  // The composition: applies `first`, then this.
  AffineColor After(const AffineColor& first) const;

  // In place, on every pixel of a planar image.
  template <class S>
  void Apply(HostSpan<S> image) const;
};

// The change of a lens relative to the given one. Focal lengths are multiplied by exp(log_focal), and the principal
// point moves by `shift`, in units of the given focal lengths. It is independent of the image size. The default is no
// change.
struct LensChange {
  double log_focal[2] = {}, shift[2] = {};

  bool operator==(const LensChange&) const = default;
  bool is_none() const { return *this == LensChange{}; }
  // True if the change is plausible: focal lengths change by less than a factor of e, and the principal point moves by
  // less than half a focal length.
  bool is_sound() const;
  // Applies the change to the given lens. The default change keeps every bit.
  splat::Lens Of(const splat::Lens& given) const;
};

// The change that applies `change` first, then the step `delta`, which is relative to the changed lens (LensTangent).
LensChange Compose(const splat::LensTangent& delta, const LensChange& change);

// The values of a view's unknowns, relative to its given camera; by default no change. `motion` applies in camera
// coordinates after the given pose. `color` maps the rendered image to the photograph.
struct ViewUnknowns {
  splat::CameraMotion motion = {};
  AffineColor color = {};
  LensChange lens = {};
};

// ViewUnknowns as a vector for the solver: quaternion (4 numbers), translation (3), gains (3), offsets (3). The lens is
// left out, since the solver does not optimise it.
inline constexpr Index kViewParameters = 13;
void Pack(const ViewUnknowns& unknowns, HostSpan<double> x);
ViewUnknowns Unpack(HostSpan<const double> x);

// Selects the free unknowns, which are optimised; the others are fixed. A step (a change of the free unknowns) has, in
// this order, the numbers of the free ones among: six of the pose (splat::PoseTangent), three gains, three offsets,
// four of the lens (splat::LensTangent).
struct FreeUnknowns {
  bool pose = true;
  bool color = false;
  bool lens = false;

  constexpr int pose_tangent() const { return pose ? splat::kPoseTangent : 0; }
  constexpr int color_tangent() const { return color ? 2 * ImageShape::kChannels : 0; }
  constexpr int lens_tangent() const { return lens ? splat::kLensTangent : 0; }
  constexpr int num_tangent() const { return pose_tangent() + color_tangent() + lens_tangent(); }
  // The number of unknowns that move Gaussians in the image.
  constexpr int num_moves() const { return pose_tangent() + lens_tangent(); }
  // Indices in a step.
  constexpr int Gain(int channel) const { return pose_tangent() + channel; }
  constexpr int Offset(int channel) const { return Gain(ImageShape::kChannels) + channel; }
  constexpr int Lens(int k) const { return pose_tangent() + color_tangent() + k; }
  // The same selection without the lens, which views may share. Its numbers come first in a step.
  constexpr FreeUnknowns OwnOfView() const { return {pose, color}; }
};

// Applies a step `delta`: motions and lenses are composed with it (Compose), gains and offsets are added. Fixed
// unknowns do not change.
ViewUnknowns Plus(const ViewUnknowns& unknowns, const FreeUnknowns& free, HostSpan<const double> delta);

// Camera changes over all views: the median of the rotation angle, the median and the maximum of MedianShift, the
// maximum of |gain - 1|, and the maximum relative change of a focal length.
struct CameraChanges {
  double degrees = 0, pixels = 0, most_pixels = 0, most_gain = 0, most_focal = 0;

  bool is_none() const { return degrees == 0 && most_pixels == 0 && most_gain == 0; }
};

// given and found have the same length and order. near: distance of the near plane, world units.
CameraChanges ChangesOf(const SplatModel& model, const std::vector<const View*>& given,
                        const std::vector<ViewUnknowns>& found, double near);

// The camera unknowns to optimise during training.
enum class CameraChoice {
  kNone,
  kPose,
  kPoseAndExposure,
  kAll,   // also lenses (focal lengths and principal point), shared by the views of a camera
  kAuto,  // decided from the improvement of held-out views (EvidenceOf)
};
inline constexpr schema::Choice<CameraChoice> kCameraChoices[] = {{CameraChoice::kNone, "none"},
                                                                  {CameraChoice::kPose, "pose"},
                                                                  {CameraChoice::kPoseAndExposure, "pose+exposure"},
                                                                  {CameraChoice::kAll, "all"},
                                                                  {CameraChoice::kAuto, "auto"}};
static_assert(schema::AreDistinct(kCameraChoices));

struct CameraOptions {
  CameraChoice refine = CameraChoice::kNone;

  bool refines() const { return refine != CameraChoice::kNone; }
};

const schema::Table<CameraOptions>& CameraFields();

// The free unknowns for a choice; kAuto gives none until it is resolved.
FreeUnknowns FreeBy(CameraChoice choice);

}  // namespace vesta::gs
