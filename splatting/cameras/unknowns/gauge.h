// SPDX-License-Identifier: Apache-2.0
// The gauge of cameras and splat, and the prior that fixes it where both are optimised at once.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// What no photograph tells: where the whole of cameras and splat lies, how it is turned, how large it is, and how
// bright all photographs are; and what an unfinished splat tells wrongly.
//
// Takes out of what was found what all views share: the similarity of the world (7 numbers) that comes nearest to the
// motions, by least squares of turns, times `depth`, and of centres; and of the exposures, by channel, the affine map
// whose removal leaves gains with the mean 1 and offsets with the mean 0. So the views lie on the whole where they were
// given. given: as many, in the same order. depth: of what they see, world units, > 0. Where views leave a freedom
// undetermined (one view, or all centres in one place, but for how they were moved: the scale) it is not touched.
void FixCameraGauge(const std::vector<const View*>& given, double depth, std::vector<ViewUnknowns>* found);
void FixExposureGauge(std::vector<ViewUnknowns>* found);

// Takes out the mean turn of all views in their own axes, about their centres. Photographs hardly tell of it where
// cameras stand in a ring: that all tilt, and the scene sinks, is nearly the same. So the errors of a splat that is not
// finished go into it, and come out slowly (docs/decisions/mean-camera-rotation.md). The mean of the turns by which
// cameras are wrong, each by its own, is small.
void SubtractMeanRotation(std::vector<ViewUnknowns>* found);

// What holds the freedoms that no photograph tells of where cameras, exposures and splats are found at once:
// a weak pull of each view to where it was given.
//
// Adds weight / 2 (4 |v|^2 + |t|^2 / depth^2 + |gain - 1|^2 + |offset|^2) to the cost of a view, for each of its
// image's values; v: the vector part of the motion's quaternion, so that 2 |v| is the angle while that is small; t: its
// translation. Only of what is free. It biases what photographs tell little of: by the default, gains of 0.9 to 1.1 of
// small dark photographs came out up to 0.02 too near to 1, by 1e-4 up to 0.003.
struct ViewPrior {
  double weight = 0.01;  // >= 0
  double depth = 1;      // of what the views see, world units, > 0

  // Residuals, whose squares halved are that, of an image of so many values; free.num_tangent() of them.
  std::vector<double> Residuals(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const;
  // Their derivative by a step of the view (Plus): square, row by row.
  std::vector<double> Jacobian(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const;
};

}  // namespace vesta::gs
