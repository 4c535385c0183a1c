// SPDX-License-Identifier: Apache-2.0
// The gauge of cameras and splat, and a prior that fixes it when both are optimised jointly.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Functions that fix the gauge: the position, orientation and scale of the whole scene, and the brightness of all
// photographs. No photograph determines these.
//
// FixCameraGauge removes the similarity (7 numbers) that is common to all camera motions. The similarity is a
// least-squares fit to the rotations, times `depth`, and to the camera centres. `given` has the views in the same order
// as `found`. `depth` (> 0, world units) is the depth of the scene in front of the cameras. A freedom that the views do
// not determine stays unchanged, such as the scale for one view or for coinciding given centres. FixExposureGauge
// removes, per channel, the common affine map: then the mean gain is 1 and the mean offset 0.
void FixCameraGauge(const std::vector<const View*>& given, double depth, std::vector<ViewUnknowns>* found);
void FixExposureGauge(std::vector<ViewUnknowns>* found);

// Subtracts the mean rotation of all views, each about its own axes and centre. For cameras in a ring the photographs
// hardly determine it: when all cameras tilt and the scene sinks, the images stay nearly the same. So it collects the
// errors of an unfinished splat and loses them slowly (docs/decisions/mean-camera-rotation.md). Independent errors of
// the given cameras have a small mean.
void SubtractMeanRotation(std::vector<ViewUnknowns>* found);

// A weak prior that fixes the gauge when cameras, exposures and splats are optimised jointly: it pulls each view
// towards its given camera.
//
// For each value of the view's image, the prior adds weight / 2 (4 |v|^2 + |t|^2 / depth^2 + |gain - 1|^2 + |offset|^2)
// to the cost. Terms of fixed unknowns are left out. v is the vector part of the motion's quaternion (2 |v| is the
// angle, if small), t the translation. The prior biases weakly determined unknowns. Under the default weight gains of
// 0.9 to 1.1 of small dark photographs were up to 0.02 too close to 1; with weight 1e-4, up to 0.003.
struct ViewPrior {
  double weight = 0.01;  // >= 0
  double depth = 1;      // depth of the scene in front of the views, world units, > 0

  // Residuals for an image of `values` numbers; half their squared norm is the cost above. free.num_tangent() of them.
  std::vector<double> Residuals(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const;
  // The derivative of the residuals with respect to a step of the view (Plus): square, row-major.
  std::vector<double> Jacobian(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const;
};

}  // namespace vesta::gs
