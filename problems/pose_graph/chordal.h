// SPDX-License-Identifier: Apache-2.0
// A start for pose-graph optimisation from the measurements alone, by two sparse linear solves.
#pragma once

#include <optional>
#include <vector>

#include "problems/pose_graph/pose_graph.h"

namespace vesta::pose_graph {

struct PlannedPattern;

// Weights of an edge for the isotropic errors kappa |R_b - R_a R_m|^2 (Frobenius norm) and tau |p_b - p_a - R_a p_m|^2,
// from its information matrix. tau is the harmonic mean of the eigenvalues of the position block. kappa is half the
// harmonic mean for the rotation block, because the square of the norm is about twice the square of the angle. In 3D,
// SE-Sync has the same weights (Rosen et al. 2019, "SE-Sync: a certifiably correct algorithm for synchronization over
// the special Euclidean group"); in 2D, its code has twice this kappa. 0 where a block is singular.
struct IsotropicWeights {
  double rotation = 0;     // kappa
  double translation = 0;  // tau
};
IsotropicWeights IsotropicWeightsOf(const PoseGraph& graph, Index edge);

// The poses that each component of the graph keeps: all fixed ones, and the first of a component without a fixed one.
std::vector<bool> HeldPoses(const PoseGraph& graph);

// Poses by chordal relaxation (Martinec and Pajdla 2007, "Robust rotation and translation estimation in multiview
// reconstruction"): matrices X minimise the sum of kappa |X_b - X_a R_m|^2 and are then projected to the nearest
// rotations; with these, positions minimise the sum of tau |p_b - p_a - R_a p_m|^2. Held poses (HeldPoses) keep
// graph.poses. The result has the form of graph.poses and does not depend on the others. Returns nothing if a factor
// would take more than max_factor_gib. planned: PoseGraphProblem::Planned of this graph, which saves planning the
// factors; null: no plan.
std::optional<std::vector<double>> ChordalPoses(const PoseGraph& graph, double max_factor_gib = 4,
                                                const PlannedPattern* planned = nullptr);

}  // namespace vesta::pose_graph
