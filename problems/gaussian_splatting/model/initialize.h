// SPDX-License-Identifier: Apache-2.0
// The initial model of a training, and the order of Gaussians along a space-filling curve.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Returns for each point the mean of the squared distances to its 3 nearest neighbours, as in Kerbl et al. 2023 (3D
// Gaussian Splatting). With fewer than 4 points it uses all others; a single point gives 0. Points at equal positions
// have distance 0, so the mean may be 0. Positions must be finite. The result is bit-identical for any number of
// threads.
std::vector<float> MeanSquaredNeighborDistance(const std::vector<std::array<float, 3>>& positions);

// The initial model: one Gaussian at each point, with the position and colour of the point (Kerbl et al. 2023, section
// 5.1). Gaussians are round: the standard deviation is the root mean square distance to the three nearest neighbours,
// but at least 1e-4 of `extent` (Scene::extent). Opacity is 0.1, the quaternion 1, harmonics above degree 0 are zero.
// If there are more points than max_gaussians, an evenly spaced subset in their order is used. Throws Error without
// points.
SplatModel InitializeFromPoints(const PointCloud& points, double extent, int sh_degree, Index max_gaussians);

// Default degree of spherical harmonics for this number of training views: 2 for fewer than 24, otherwise 3. Degree 3
// has 16 coefficients per channel; with 17 and 21 views degree 2 gave better test views (docs/decisions/sh-degree.md).
int DefaultShDegree(Index training_views);

// Returns an order of the Gaussians in which neighbours in memory are mostly neighbours in space: entry k is the index
// of the Gaussian at place k.
//
// Gaussians are sorted by SH degree, highest first, then along a Z-order curve through their means (Morton 1966) with
// 21 bits per axis. Consecutive Gaussians, which fill a SIMD vector, are then mostly all inside or all outside a view,
// and passes over the Gaussians skip the vectors outside. A coordinate that is not finite counts as the largest.
std::vector<Index> SpatialOrder(const SplatModel& model);

// Returns the model in this order: Gaussian k of the result is Gaussian order[k] of the model. Throws Error if a
// Gaussian of the result would have a higher SH degree than the one before it.
SplatModel InOrder(SplatModel model, const std::vector<Index>& order);

}  // namespace vesta::gs
