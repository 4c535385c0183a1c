// What is unknown of a view, beside the Gaussians: how its camera moves, its lens, and the exposure of its photograph.
#pragma once

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/projection/camera_motion.h"
#include "kernels/image/image_shape.h"
#include "splatting/cameras/unknowns/affine_color.h"
#include "splatting/cameras/unknowns/lens_change.h"

namespace vesta::gs {

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

}  // namespace vesta::gs
