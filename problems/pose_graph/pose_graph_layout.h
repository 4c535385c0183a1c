// SPDX-License-Identifier: Apache-2.0
// Where the parts of a pose graph lie in vectors and matrices: made once for a problem.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "problems/pose_graph/edge_terms.h"
#include "solver/internal/sparse_cholesky/block_matrix.h"

namespace vesta::pose_graph {

// One end of an edge: side 0 is `from`, 1 is `to`.
struct EdgeEnd {
  Index edge;
  int side;
};

struct PoseGraphLayout {
  EdgeTerms terms;
  std::vector<Index> row_of_pose;  // block row in the tangent space, -1 for held poses
  std::vector<Index> pose_of_row;
  std::shared_ptr<const BlockPattern> pattern;  // of H
  std::vector<std::size_t> first_end;           // into ends, for each row, and the end
  std::vector<EdgeEnd> ends;                    // the edges at each row, ascending
  std::vector<std::size_t> first_edge;          // into edges_of_block, for each block of the pattern, and the end
  std::vector<Index> edges_of_block;            // ascending

  int tangent() const { return terms.tangent(); }
  Index num_tangent() const { return static_cast<Index>(pose_of_row.size()) * tangent(); }
  // The row of one end of an edge, or -1.
  Index Row(Index edge, int side) const {
    const PoseGraph::Edge& e = terms.edges[static_cast<std::size_t>(edge)];
    return row_of_pose[static_cast<std::size_t>(side == 0 ? e.from : e.to)];
  }
  std::span<const EdgeEnd> EndsAt(Index row) const {
    const auto r = static_cast<std::size_t>(row);
    return std::span(ends).subspan(first_end[r], first_end[r + 1] - first_end[r]);
  }
  std::span<const Index> EdgesOf(Index block) const {
    const auto b = static_cast<std::size_t>(block);
    return std::span(edges_of_block).subspan(first_edge[b], first_edge[b + 1] - first_edge[b]);
  }
};

// held: positions of the poses that do not move.
PoseGraphLayout MakeLayout(EdgeTerms terms, Index num_poses, std::span<const Index> held);

}  // namespace vesta::pose_graph
