// SPDX-License-Identifier: Apache-2.0
// What no photograph tells: where the whole of cameras and splat lies, how it is turned, how large it is, and how
// bright all photographs are; and what an unfinished splat tells wrongly.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Takes out of what was found what all views share: the similarity of the world (7 numbers) that comes nearest to the
// motions, by least squares of turns, times `depth`, and of centres; and of the exposures, by channel, the affine map
// whose removal leaves gains with the mean 1 and offsets with the mean 0. So the views lie on the whole where they were
// given. given: as many, in the same order. depth: of what they see, world units, > 0. Where views leave a freedom
// undetermined (one view, or all centres in one place, but for how they were moved: the scale) it is not touched.
void RemoveCommonMotion(const std::vector<const View*>& given, double depth, std::vector<ViewUnknowns>* found);
void RemoveCommonExposure(std::vector<ViewUnknowns>* found);

// Takes out the mean turn of all views in their own axes, about their centres. Photographs hardly tell of it where
// cameras stand in a ring: that all tilt, and the scene sinks, is nearly the same. So the errors of a splat that is not
// finished go into it, and come out slowly (docs/results, cameras-in-training). The mean of the turns by which cameras
// are wrong, each by its own, is small.
void RemoveCommonTurn(std::vector<ViewUnknowns>* found);

}  // namespace vesta::gs
