// What is unknown of a view, beside the Gaussians: how its camera moves, and the exposure of its photograph.
#pragma once

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/camera_motion.h"
#include "kernels/image/image_shape.h"
#include "problems/gaussian_splatting/cameras/affine_color.h"

namespace vesta::gs {

// A point of the manifold, from where a view starts.
struct ViewUnknowns {
  splat::CameraMotion motion;
  AffineColor color;
};

// The same as a vector of the engine: quaternion, translation, gains, offsets.
inline constexpr Index kViewParameters = 13;
void Pack(const ViewUnknowns& unknowns, HostSpan<double> x);
ViewUnknowns Unpack(HostSpan<const double> x);

// Which of them are to be found. A step is first the pose's six numbers (splat::PoseTangent), then three gains and
// three offsets, of those that are.
struct FreeUnknowns {
  bool pose = true;
  bool color = false;

  int pose_tangent() const { return pose ? splat::kPoseTangent : 0; }
  int num_tangent() const { return pose_tangent() + (color ? 2 * ImageShape::kChannels : 0); }
  // Places in a step.
  int Gain(int channel) const { return pose_tangent() + channel; }
  int Offset(int channel) const { return Gain(ImageShape::kChannels) + channel; }
};

// x (+) delta: the motion's retraction (Compose), a sum for the colours. What is not free stays.
ViewUnknowns Plus(const ViewUnknowns& unknowns, const FreeUnknowns& free, HostSpan<const double> delta);

}  // namespace vesta::gs
