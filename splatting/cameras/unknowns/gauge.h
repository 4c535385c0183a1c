// SPDX-License-Identifier: Apache-2.0
// Functions and a prior that fix the gauge of cameras and splat: common changes that no photograph shows, such as
// moving the whole scene.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// No photograph determines the position, orientation and scale of the whole scene, nor the common brightness.
//
// FixCameraGauge removes the similarity (rotation, translation and scale: 7 numbers) that all camera motions have in
// common. It is a least-squares fit to the shifts of the camera centres and to the camera rotations times `depth`.
// `given`: the views with their given cameras, in the order of `found`. `depth`: depth of the scene in front of the
// cameras, world units, > 0. Numbers that the views do not determine stay unchanged, such as the scale if the given
// centres nearly coincide. FixExposureGauge removes, per channel, the common affine map: then the mean gain is 1 and
// the mean offset 0.
void FixCameraGauge(const std::vector<const View*>& given, double depth, std::vector<ViewUnknowns>* found);
void FixExposureGauge(std::vector<ViewUnknowns>* found);

// Subtracts from each view's rotation, in camera axes, the mean over all views. For cameras in a ring the photographs
// hardly determine this mean: if all cameras tilt upwards while the scene sinks, the images stay nearly the same.
// Without this, it drifts while the splat is inaccurate, and returns slowly (docs/decisions/mean-camera-rotation.md).
// Independent errors of the given cameras have a small mean, so little is lost.
void SubtractMeanRotation(std::vector<ViewUnknowns>* found);

// A weak prior that fixes the gauge in joint optimisation: it pulls each view towards its given camera.
//
// For an image of n values (pixels times channels), it adds to the cost
// n * weight / 2 * (4 |v|^2 + |t|^2 / depth^2 + |gain - 1|^2 + |offset|^2),
// without the terms of fixed unknowns. v is the vector part of the motion's quaternion (2 |v| is the angle, if small),
// t the translation. The prior biases weakly determined unknowns, such as the gains of small dark photographs.
struct ViewPrior {
  double weight = 0.01;  // >= 0
  double depth = 1;      // depth of the scene in front of the views, world units, > 0

  // free.num_tangent() numbers; half their squared norm is the cost above. values: n above.
  std::vector<double> Residuals(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const;
  // Derivative of the residuals for a step of the view (Plus): square, row-major.
  std::vector<double> Jacobian(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const;
};

}  // namespace vesta::gs
