// SPDX-License-Identifier: Apache-2.0
// Solves a pose graph that has wrong loop closures.
#pragma once

#include <vector>

#include "problems/pose_graph/pose_graph.h"
#include "problems/pose_graph/solve.h"

namespace vesta::pose_graph {

struct RobustSolveOptions {
  // problem.loss must be null.
  PoseGraphSolveOptions solve;
  // Probability of rejecting any true closure, in each test of all of them; > 0 and < 1.
  double significance = 0.05;
};

struct RobustSolution {
  PoseGraphSolution solution = {};  // of the kept edges; its start is the one of the first solve
  std::vector<bool> kept = {};      // by edge
  Index num_closures = 0;
  Index num_rejected = 0;
  int num_solves = 0;
  // Mean squared residual of the kept edges per degree of freedom, at least 1. Their information is too large by this
  // factor.
  double information_scale = 1;
};

// Rejects wrong closures, and solves the graph with the others. Trusts the odometry, which is the edges between
// consecutive vertex ids.
//
// First it solves the graph of the closures that CheckClosures (closure_check.h) supports. Then it keeps each closure
// whose squared residual r^T Lambda r is below T, and solves again, until the same closures are kept, or 20 times. T is
// information_scale times the chi-square quantile of significance / number of closures. The poses are then a minimum of
// the truncated cost, the sum of min(r^T Lambda r, T) (Yang et al. 2020, "Graduated non-convexity for robust spatial
// perception", equation 5).
//
// If other closures are likely (closure_check.h), it does the same from these, and returns the result with the lower
// truncated cost. This comparison uses the smaller mean square of the two results instead of information_scale.
//
// solve.lm.max_iterations and solve.lm.max_seconds limit all solves together. callback: see SolveLm; it receives the
// iterations of all solves. If it stops one, that is the last. Throws Error as PoseGraphProblem does, for options out
// of range, and for landmarks and priors (PoseGraph::world), which are not checked.
RobustSolution SolveRobustPoseGraph(const PoseGraph& graph, const RobustSolveOptions& options = RobustSolveOptions(),
                                    const LmCallback& callback = {});

}  // namespace vesta::pose_graph
