// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/pose_graph_layout.h"

#include <numeric>
#include <utility>

namespace vesta::pose_graph {
namespace {

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

// Turns counts, each one place to the right of its owner, into first positions.
void AccumulateCounts(std::vector<std::size_t>* counts) {
  std::partial_sum(counts->begin(), counts->end(), counts->begin());
}

}  // namespace

PoseGraphLayout MakeLayout(EdgeTerms terms, Index num_poses, std::span<const Index> held) {
  PoseGraphLayout layout;
  layout.terms = std::move(terms);
  layout.row_of_pose.assign(At(num_poses), 0);
  for (const Index pose : held) layout.row_of_pose[At(pose)] = -1;
  for (Index pose = 0; pose < num_poses; ++pose) {
    if (layout.row_of_pose[At(pose)] < 0) continue;
    layout.row_of_pose[At(pose)] = static_cast<Index>(layout.pose_of_row.size());
    layout.pose_of_row.push_back(pose);
  }

  const Index num_edges = layout.terms.num_edges();
  std::vector<BlockPattern::Pair> pairs;
  std::vector<Index> edge_of_pair;
  layout.first_end.assign(layout.pose_of_row.size() + 1, 0);
  for (Index e = 0; e < num_edges; ++e) {
    const Index rows[2] = {layout.Row(e, 0), layout.Row(e, 1)};
    for (const Index row : rows) {
      if (row >= 0) ++layout.first_end[At(row) + 1];
    }
    if (rows[0] < 0 || rows[1] < 0) continue;
    pairs.push_back({rows[0], rows[1]});
    edge_of_pair.push_back(e);
  }
  AccumulateCounts(&layout.first_end);
  layout.ends.resize(layout.first_end.back());
  std::vector<std::size_t> next(layout.first_end.begin(), layout.first_end.end() - 1);
  for (Index e = 0; e < num_edges; ++e) {
    for (const int side : {0, 1}) {
      if (const Index row = layout.Row(e, side); row >= 0) layout.ends[next[At(row)]++] = {e, side};
    }
  }

  const std::vector<int> sizes(layout.pose_of_row.size(), layout.tangent());
  layout.pattern = std::make_shared<BlockPattern>(sizes, pairs);
  const std::vector<Index>& block_of_pair = layout.pattern->block_of_pair();
  layout.first_edge.assign(At(layout.pattern->num_blocks()) + 1, 0);
  for (const Index block : block_of_pair) ++layout.first_edge[At(block) + 1];
  AccumulateCounts(&layout.first_edge);
  layout.edges_of_block.resize(block_of_pair.size());
  next.assign(layout.first_edge.begin(), layout.first_edge.end() - 1);
  for (std::size_t k = 0; k < block_of_pair.size(); ++k) {
    layout.edges_of_block[next[At(block_of_pair[k])]++] = edge_of_pair[k];
  }
  return layout;
}

}  // namespace vesta::pose_graph
