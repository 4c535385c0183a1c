// SPDX-License-Identifier: Apache-2.0
// Plans a sparse Cholesky factorisation: the elimination order, the rows of blocks that are eliminated together, and
// the destination of each result. The plan depends on the pattern only.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "solver/internal/sparse_cholesky/block_matrix.h"

namespace vesta {

// A dense front of the multifrontal method (Duff and Reid, 1983). It eliminates the rows of blocks first..first +
// pivots, numbered in elimination order. `below` lists its other rows.
struct EliminationFront {
  // A block of the matrix that this front assembles.
  struct Entry {
    Index row, col;  // its first scalar in the front
    int rows, cols;
    Index source;  // index of the original row of a diagonal block, or of an off-diagonal block
    bool diagonal;
    bool transposed;  // true if block (col, row) is stored
  };
  // Scalars [begin, end), counted from the first one below the pivots, that are contiguous elsewhere, from `to` on.
  struct Run {
    Index begin, end, to;
  };
  Index first = 0, pivots = 0;
  std::vector<Index> below;                        // rows coupled to the pivots, ascending
  Index parent = -1;                               // front that receives the update; -1 for roots
  std::vector<Index> children;                     // ascending
  Index first_scalar = 0;                          // position of the pivots in elimination order
  Index pivot_scalars = 0, scalars = 0;            // number of scalars of the pivots, and of all rows
  std::vector<Run> runs_in_order, runs_in_parent;  // positions of the rows below: in elimination order, in the parent
  std::vector<Entry> entries;
};

// The fronts [begin, end) of a whole subtree. Children come before parents.
struct EliminationSubtree {
  Index begin, end;
};

// Subtrees [begin, end) that are eliminated in parallel. Their updates are added to their parents before the next wave.
struct EliminationWave {
  Index begin, end;
};

struct EliminationPlan {
  // The k-th row to be eliminated.
  struct Row {
    Index original;  // its index in the pattern
    Index source;    // its first scalar in the matrix
    Index position;  // its first scalar in elimination order
    int size;
  };
  std::vector<Row> order;
  Index num_scalars = 0;
  std::vector<EliminationFront> fronts;
  // Disjoint subtrees with little work each, which threads take one by one.
  std::vector<EliminationSubtree> subtrees;
  // The waves contain all subtrees. The updates of one wave take at most 64 MiB, unless it is a single subtree. Without
  // waves, a front with thousands of child subtrees (cameras over points) would need all their updates in memory at
  // once.
  std::vector<EliminationWave> waves;
  // The fronts above the subtrees. Fronts of one level depend on earlier levels only, not on each other.
  std::vector<std::vector<Index>> levels;
  double factor_values = 0;    // factor values, including the zeros in merged fronts
  double update_values = 0;    // passed from fronts to their parents
  double multiplications = 0;  // of the factorisation
};

// Limits on the factor; PlanElimination returns nothing above them.
struct EliminationLimits {
  double factor_values = std::numeric_limits<double>::infinity();
  double multiplications = std::numeric_limits<double>::infinity();
};

// Plans the elimination. The order is by approximate minimum degree (Amestoy, Davis, Duff, 1996). A front is merged
// with its parent if that stores few additional zeros (relaxed supernodes, Ashcraft and Grimes, 1989). Returns nothing
// if the factor exceeds the limits even before fronts are merged. This test needs much less memory than the plan.
std::optional<EliminationPlan> PlanElimination(const BlockPattern& pattern, const EliminationLimits& limits = {});

}  // namespace vesta
