// Distances to nearest neighbours, the initial sizes of Gaussians.
#pragma once

#include <array>
#include <vector>

namespace vesta::gs {

// For each point the mean of the squared distances to its 3 nearest others (to all others where there are fewer; 0 for
// a single point). Coinciding points are neighbours at distance 0, so the mean may be 0. Positions must be finite.
// As in Kerbl et al. 2023. Parallel; the same bits for any number of threads.
std::vector<float> MeanSquaredNeighborDistance(const std::vector<std::array<float, 3>>& positions);

}  // namespace vesta::gs
