// SPDX-License-Identifier: Apache-2.0
// The initial model of a training, and the order of Gaussians along a space-filling curve.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// For each point the mean of the squared distances to its 3 nearest neighbours (fewer if there are fewer points; 0 for
// a single point). Coinciding points are neighbours at distance 0, so the mean may be 0. Positions must be finite. As
// in Kerbl et al. 2023. Parallel; bit-identical for any number of threads.
std::vector<float> MeanSquaredNeighborDistance(const std::vector<std::array<float, 3>>& positions);

// The initial model: one Gaussian at each point, with the position and colour of the point (Kerbl et al. 2023, section
// 5.1). Its size is isotropic: the root mean square distance to the three nearest neighbours, but at least 1e-4 of the
// scene extent. Opacity is 0.1; there is no rotation. If there are more points than max_gaussians, an evenly strided
// subset is used. Points must not be empty.
SplatModel InitializeFromPoints(const PointCloud& points, double extent, int sh_degree, Index max_gaussians);

// Default degree of spherical harmonics for this number of training views: 2 for fewer than 24, otherwise 3. Degree 3
// has 16 coefficients per channel; with 17 and 21 views degree 2 gave better test views (docs/decisions/sh-degree.md).
int DefaultShDegree(Index training_views);

// An order of the Gaussians in which neighbours in memory are neighbours in space. Returns the old indices in their new
// order.
//
// Gaussians are sorted by degree, then along a Z-order curve through their means (Morton 1966), with 21 bits per axis.
// Whole SIMD vectors of Gaussians are then inside or outside a view, so passes over all Gaussians can skip those
// outside. Means that are not finite come last within their degree.
std::vector<Index> SpatialOrder(const SplatModel& model);

// Gaussian k of the result is Gaussian order[k] of the model. Throws Error if a Gaussian has a higher degree than the
// one before it.
SplatModel InOrder(SplatModel model, const std::vector<Index>& order);

}  // namespace vesta::gs
