// SPDX-License-Identifier: Apache-2.0
// Checks the loop closures of a pose graph against each other, without poses: the measurements along a closed path must
// compose to the identity, up to their noise.
#pragma once

#include <vector>

#include "problems/pose_graph/pose_graph.h"

namespace vesta::pose_graph {

// Whether the edge joins consecutive vertex ids. These edges are odometry, and are trusted. All others are closures.
bool IsOdometry(const PoseGraph& graph, Index edge);

// Root mean square distance of the positions from their mean, world units. poses: as PoseGraph::poses, at least one.
double PositionExtent(const PoseGraph& graph, const std::vector<double>& poses);

// The same poses with a part of the edges. kept: one value per edge.
PoseGraph WithEdges(const PoseGraph& graph, const std::vector<bool>& kept);

// The value that a chi-square variable exceeds with this probability, up to rounding. degrees >= 1; probability > 0 and
// < 1; otherwise throws Error.
double ChiSquareQuantile(int degrees, double probability);

struct ClosureCheck {
  // By edge; true for odometry. Fewer than 0.01 wrong closures are expected among the supported ones, and fewer than 1
  // among the likely ones.
  std::vector<bool> supported, likely;
  // The factors by which the errors of short cycles exceed their variances (1 if the information is exact).
  double rotation_scale = 1, position_scale = 1;
};

// For each closure, composes the measurements along the path with the fewest edges between its two poses, and compares
// the result with the closure. The variances of rotation and position follow from isotropic weights (chordal.h), to
// first order. The chi-square tests of the errors reject any true closure with the probability `significance` in all.
// Scale factors of the variances are estimated from the shorter half of the cycles, because wrong closures rarely have
// short ones. Later rounds find paths over the closures that passed, until the number of supported closures is stable.
//
// A long cycle has a large variance, so a wrong closure may pass. The chance of this is the volume that the test
// accepts, relative to all rotations and to a ball with the extent of the odometry. Closures are accepted in ascending
// order of this chance. The closures that failed determine the expected number of wrong ones among the accepted ones.
// It stays below 0.01 (supported) or 1 (likely). A closure without another path between its poses is
// supported.
//
// Checking closures by cycles before the optimisation is known from RRR (Latif, Cadena, Neira 2013) and from pairwise
// consistency (Mangelson et al. 2018). significance: > 0 and < 1. Throws Error as PoseGraphProblem does.
ClosureCheck CheckClosures(const PoseGraph& graph, double significance = 0.05);

}  // namespace vesta::pose_graph
