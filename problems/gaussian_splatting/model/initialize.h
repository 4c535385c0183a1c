// SPDX-License-Identifier: Apache-2.0
// The model that a training starts from, and the order of Gaussians along a curve through space.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// For each point the mean of the squared distances to its 3 nearest others (to all others where there are fewer; 0 for
// a single point). Coinciding points are neighbours at distance 0, so the mean may be 0. Positions must be finite.
// As in Kerbl et al. 2023. Parallel; the same bits for any number of threads.
std::vector<float> MeanSquaredNeighborDistance(const std::vector<std::array<float, 3>>& positions);

// The first model: one Gaussian at each point. Mean and colour of the point, an isotropic size equal to the root mean
// square distance to its three nearest neighbours but at least 1e-4 of the scene's extent, opacity 0.1, no rotation
// (Kerbl et al. 2023, section 5.1). Where there are more points than max_gaussians, evenly strided ones are kept.
// Points must not be empty.
SplatModel InitializeFromPoints(const PointCloud& points, double extent, int sh_degree, Index max_gaussians);

// The degree of spherical harmonics that so many training views bear: 2 for fewer than 24, else 3. Degree 3 has 16
// coefficients a channel, and with 17 and 21 views those of degree 2 gave the better test views
// (docs/decisions/sh-degree.md).
int DefaultShDegree(Index training_views);

// Gaussians in an order in which neighbours in memory are neighbours in space.
//
// The Gaussians of the model, those of each degree along a Z-order curve through their means (Morton 1966), 21 bits an
// axis: old indices in their new order. A view then sees and misses whole vectors of Gaussians, and the passes over all
// of them skip what it misses. Means that are not finite come last of their degree.
std::vector<Index> SpatialOrder(const SplatModel& model);

// Gaussian k of the result is Gaussian order[k] of the model. Throws Error where one has a higher degree than the one
// before it.
SplatModel InOrder(SplatModel model, const std::vector<Index>& order);

}  // namespace vesta::gs
