// SPDX-License-Identifier: Apache-2.0
// The unknowns of a view (pose, lens and exposure), and the option that selects the unknowns to optimise in training.
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

// An exposure: maps a value of channel c, as stored in the image file, 0 to 1, to gain[c] * value + offset[c].
struct AffineColor {
  std::array<double, 3> gain{1, 1, 1}, offset{};

  bool operator==(const AffineColor&) const = default;
  bool is_none() const { return *this == AffineColor{}; }
  // No gain may be 0.
  AffineColor Inverse() const;
  // Applies `first`, then this.
  AffineColor After(const AffineColor& first) const;

  // Changes every pixel of a planar image.
  template <class S>
  void Apply(HostSpan<S> image) const;
};

// The change of a lens. Focal lengths are multiplied by exp(log_focal), and the principal point moves by `shift`, in
// units of the given focal lengths. Independent of the image size.
struct LensChange {
  double log_focal[2] = {}, shift[2] = {};

  bool operator==(const LensChange&) const = default;
  bool is_none() const { return *this == LensChange{}; }
  // True if focal lengths change by less than a factor of e, and the principal point by less than half a focal length.
  bool is_sound() const;
  // The default change keeps every bit.
  splat::Lens Of(const splat::Lens& given) const;
};

// Applies `change` first, then the step `delta`, relative to the changed lens (LensTangent).
LensChange Compose(const splat::LensTangent& delta, const LensChange& change);

// The unknowns of a view, relative to its given camera. `motion` applies in camera coordinates after the given pose.
// `color` maps the rendered image to the photograph.
struct ViewUnknowns {
  splat::CameraMotion motion = {};
  AffineColor color = {};
  LensChange lens = {};
};

// A vector for the solver: quaternion (4 numbers), translation (3), gains (3), offsets (3). The solver does not
// optimise the lens.
inline constexpr Index kViewParameters = 13;
void Pack(const ViewUnknowns& unknowns, HostSpan<double> x);
ViewUnknowns Unpack(HostSpan<const double> x);

// Selects the free unknowns, which are optimised. A step has numbers for these only, in this order: six for the pose
// (splat::PoseTangent), three gains, three offsets, four for the lens (splat::LensTangent).
struct FreeUnknowns {
  bool pose = true;
  bool color = false;
  bool lens = false;

  constexpr int pose_tangent() const { return pose ? splat::kPoseTangent : 0; }
  constexpr int color_tangent() const { return color ? 2 * ImageShape::kChannels : 0; }
  constexpr int lens_tangent() const { return lens ? splat::kLensTangent : 0; }
  constexpr int num_tangent() const { return pose_tangent() + color_tangent() + lens_tangent(); }
  // Unknowns that move Gaussians in the image.
  constexpr int num_moves() const { return pose_tangent() + lens_tangent(); }
  // Indices in a step.
  constexpr int Gain(int channel) const { return pose_tangent() + channel; }
  constexpr int Offset(int channel) const { return Gain(ImageShape::kChannels) + channel; }
  constexpr int Lens(int k) const { return pose_tangent() + color_tangent() + k; }
  // Leaves out the lens, which views may share. The numbers of pose and exposure come first in a step.
  constexpr FreeUnknowns OwnOfView() const { return {pose, color}; }
};

// Applies a step: motions and lenses are composed with it (Compose), gains and offsets are added.
ViewUnknowns Plus(const ViewUnknowns& unknowns, const FreeUnknowns& free, HostSpan<const double> delta);

// Summary of all views: median rotation angle, median and maximum of MedianShift, maximum of |gain - 1|, and maximum
// relative change of a focal length.
struct CameraChanges {
  double degrees = 0, pixels = 0, most_pixels = 0, most_gain = 0, most_focal = 0;

  bool is_none() const { return degrees == 0 && most_pixels == 0 && most_gain == 0; }
};

// given and found have the same order. near: distance of the near plane, world units.
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

// kAuto gives none until it is resolved.
FreeUnknowns FreeBy(CameraChoice choice);

}  // namespace vesta::gs
