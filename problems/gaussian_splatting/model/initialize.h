// SPDX-License-Identifier: Apache-2.0
// The initial model of a training, and an order of Gaussians along a space-filling curve.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Per point, the mean of the squared distances to its 3 nearest neighbours, as in Kerbl et al. 2023 (3D Gaussian
// Splatting). With fewer than 4 points, the mean is over all other points; a single point gives 0. Points at equal
// positions have distance 0. Positions must be finite. Bit-identical for any number of threads.
std::vector<float> MeanSquaredNeighborDistance(const std::vector<std::array<float, 3>>& positions);

// One Gaussian at each point, with its position and colour (Kerbl et al. 2023, section 5.1). The standard deviation in
// all directions is the root mean square distance to the three nearest neighbours, at least 1e-4 of `extent`
// (Scene::extent). Opacity is 0.1, the quaternion 1, harmonics above degree 0 are zero. Uses at most max_gaussians
// points, evenly spaced in their order. Throws Error without points.
SplatModel InitializeFromPoints(const PointCloud& points, double extent, int sh_degree, Index max_gaussians);

// Default SH degree: 2 for fewer than 24 training views, otherwise 3 (docs/decisions/sh-degree.md).
int DefaultShDegree(Index training_views);

// An order in which neighbours in memory are mostly neighbours in space: entry k is the index of the Gaussian at place
// k.
//
// Gaussians are sorted by SH degree, highest first, then along a Z-order curve through their means (Morton 1966) with
// 21 bits per axis. The Gaussians of a SIMD vector are then mostly all inside or all outside a view. A coordinate that
// is not finite counts as the largest.
std::vector<Index> SpatialOrder(const SplatModel& model);

// Gaussian k of the result is Gaussian order[k] of the model. Throws Error if a Gaussian would have a higher SH degree
// than the one before it.
SplatModel InOrder(SplatModel model, const std::vector<Index>& order);

}  // namespace vesta::gs
