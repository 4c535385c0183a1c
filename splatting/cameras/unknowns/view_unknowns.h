// SPDX-License-Identifier: Apache-2.0
// The unknowns of a view: its pose, lens and exposure, and the option that chooses which of them a training finds.
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

// An exposure: value of channel c -> gain[c] value + offset[c]. Colours as stored in the file, 0 to 1. None by default.
struct AffineColor {
  std::array<double, 3> gain{1, 1, 1}, offset{};

  bool operator==(const AffineColor&) const = default;
  bool is_none() const { return *this == AffineColor{}; }
  // What takes it back. No gain may be 0.
  AffineColor Inverse() const;
  // First that one, then this.
  AffineColor After(const AffineColor& first) const;

  // In place, on every pixel of a planar image.
  template <class S>
  void Apply(HostSpan<S> image) const;
};

// The change of a lens from as it was given: focal lengths by factors exp(log_focal), the principal point by `shift`,
// in focal lengths as given. The same for the image at any size. No change by default.
struct LensChange {
  double log_focal[2] = {}, shift[2] = {};

  bool operator==(const LensChange&) const = default;
  bool is_none() const { return *this == LensChange{}; }
  // Whether it is one that a lens could need: by less than a factor of e, and half a focal length.
  bool is_sound() const;
  // The lens that was given as it is then. By no change it keeps every bit.
  splat::Lens Of(const splat::Lens& given) const;
};

// The retraction: the change, then that of the tangent at the lens as it is then.
LensChange Compose(const splat::LensTangent& delta, const LensChange& change);

// A point of the manifold, from where a view starts.
struct ViewUnknowns {
  splat::CameraMotion motion = {};
  AffineColor color = {};
  LensChange lens = {};
};

// The same as a vector of the engine, but for the lens, which engines do not look for: quaternion, translation, gains,
// offsets.
inline constexpr Index kViewParameters = 13;
void Pack(const ViewUnknowns& unknowns, HostSpan<double> x);
ViewUnknowns Unpack(HostSpan<const double> x);

// Which of them are to be found. A step is first the pose's six numbers (splat::PoseTangent), then three gains and
// three offsets, then the lens's four (splat::LensTangent), of those that are.
struct FreeUnknowns {
  bool pose = true;
  bool color = false;
  bool lens = false;

  constexpr int pose_tangent() const { return pose ? splat::kPoseTangent : 0; }
  constexpr int color_tangent() const { return color ? 2 * ImageShape::kChannels : 0; }
  constexpr int lens_tangent() const { return lens ? splat::kLensTangent : 0; }
  constexpr int num_tangent() const { return pose_tangent() + color_tangent() + lens_tangent(); }
  // By which Gaussians move in the image.
  constexpr int num_moves() const { return pose_tangent() + lens_tangent(); }
  // Places in a step.
  constexpr int Gain(int channel) const { return pose_tangent() + channel; }
  constexpr int Offset(int channel) const { return Gain(ImageShape::kChannels) + channel; }
  constexpr int Lens(int k) const { return pose_tangent() + color_tangent() + k; }
  // Without the lens, which views may share: the first numbers of a step.
  constexpr FreeUnknowns OwnOfView() const { return {pose, color}; }
};

// x (+) delta: the retractions of motion and lens (Compose), a sum for the colours. What is not free stays.
ViewUnknowns Plus(const ViewUnknowns& unknowns, const FreeUnknowns& free, HostSpan<const double> delta);

// Over the views: medians of turns and of shifts (MedianShift), the largest of these, of the gains beside 1, and of
// focal lengths as parts of themselves.
struct CameraChanges {
  double degrees = 0, pixels = 0, most_pixels = 0, most_gain = 0, most_focal = 0;

  bool is_none() const { return degrees == 0 && most_pixels == 0 && most_gain == 0; }
};

// given, found: as many. near: distance of the near plane, world units.
CameraChanges ChangesOf(const SplatModel& model, const std::vector<const View*>& given,
                        const std::vector<ViewUnknowns>& found, double near);

// What of the training views' cameras is unknown.
enum class CameraChoice {
  kNone,
  kPose,
  kPoseAndExposure,
  kAll,   // lenses too, shared by the views of a camera: focal lengths and principal points
  kAuto,  // what views that are held out gain by (EvidenceOf)
};
inline constexpr schema::Choice<CameraChoice> kCameraChoices[] = {{CameraChoice::kNone, "none"},
                                                                  {CameraChoice::kPose, "pose"},
                                                                  {CameraChoice::kPoseAndExposure, "pose+exposure"},
                                                                  {CameraChoice::kAll, "all"},
                                                                  {CameraChoice::kAuto, "auto"}};
static_assert(schema::EachOnce(kCameraChoices));

struct CameraOptions {
  CameraChoice refine = CameraChoice::kNone;

  bool refines() const { return refine != CameraChoice::kNone; }
};

const schema::Table<CameraOptions>& CameraFields();

// What is free by that choice; of kAuto nothing, before it has chosen.
FreeUnknowns FreeBy(CameraChoice choice);

}  // namespace vesta::gs
