// SPDX-License-Identifier: Apache-2.0
// The edges of a pose graph in the form the solver evaluates: whitened residuals and Jacobian blocks.
#pragma once

#include <memory>
#include <vector>

#include "problems/pose_graph/pose_graph.h"
#include "solver/loss.h"

namespace vesta::pose_graph {

struct EdgeTerms {
  PoseSpace space = PoseSpace::kSe2;
  std::vector<PoseGraph::Edge> edges;
  std::vector<double> measurements;
  std::vector<double> whitening;  // row-major TangentSize x TangentSize for each edge
  std::shared_ptr<const Loss> loss;

  Index num_edges() const { return static_cast<Index>(edges.size()); }
  int tangent() const { return TangentSize(space); }

  // 1/2 rho(|whitened residual|^2) of one edge.
  double Cost(Index edge, const double* x) const;
  // The whitened residual, TangentSize values, and its Jacobian by the steps of both poses, row-major
  // TangentSize x 2 TangentSize, both corrected for the loss.
  void Linearize(Index edge, const double* x, double* residual, double* jacobian) const;
};

}  // namespace vesta::pose_graph
