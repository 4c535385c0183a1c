// SPDX-License-Identifier: Apache-2.0
// A lower bound of the cost over all poses: proves that a solution is the global minimum, or by how much at most it may
// be missed.
#pragma once

#include <vector>

#include "problems/pose_graph/pose_graph.h"

namespace vesta::pose_graph {

struct Certificate {
  double cost = 0;         // of these poses, by EdgeError::kIsotropic
  double lower_bound = 0;  // no poses have a lower cost

  // The part of the cost by which a better solution could at most be lower; >= 0.
  double gap() const;
  // Whether the poses are globally optimal up to this part of the cost.
  bool is_optimal(double tolerance = 1e-5) const { return gap() <= tolerance; }
};

// The dual certificate of SE-Sync (Rosen et al. 2019, theorem 7). With Y = [p R], the cost is 1/2 tr(Y M Y^T) over
// rotations R. For any symmetric Lambda, block-diagonal over the rotations, let S = M - Lambda. If S + eta I is
// positive semidefinite on the rotations, no poses have a lower cost than 1/2 (tr Lambda - eta n d). Lambda is the
// Lagrange multiplier of the poses: at a global minimum S is then semidefinite for nearly all graphs whose noise is not
// extreme. Whether S + eta I is positive definite is decided by its sparse Cholesky factor; eta is the smallest of a
// geometric sequence for which it is.
//
// poses: as PoseGraph::poses, a minimum of the cost with EdgeError::kIsotropic without robust loss. (Other poses give a
// valid but useless bound.) Throws Error if more than one pose is fixed or the graph is not connected, because the
// bound would then be too low; if there are landmarks, whose rotations have no weight; or if the factor would take more
// than max_factor_gib.
Certificate Certify(const PoseGraph& graph, const std::vector<double>& poses, double max_factor_gib = 4);

}  // namespace vesta::pose_graph
