// SPDX-License-Identifier: Apache-2.0
// Plans a sparse Cholesky factorisation by the multifrontal method: elimination order, fronts, and the position of
// every value in them. The plan depends only on the pattern of the matrix. Here a row means a row of blocks.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "solver/internal/sparse_cholesky/block_matrix.h"

namespace vesta {

// A front of the multifrontal method (Duff and Reid, 1983): a small dense matrix. Its first rows, [first, first +
// pivots) in elimination order, are eliminated together. Its other rows, `below`, are coupled to the first rows. The
// elimination subtracts a matrix (the update) from the entries of the rows below, and passes it to the parent front.
struct EliminationFront {
  // A block of the matrix that is copied to this front.
  struct Entry {
    Index row, col;  // position of its first scalar in the front
    int rows, cols;
    Index source;  // of a diagonal block: its row in the pattern; of an off-diagonal block: its index in the pattern
    bool diagonal;
    bool transposed;  // true if the matrix stores the transpose of this block
  };
  // Scalars [begin, end) of the rows below, counted from 0. They are also contiguous in another vector, and begin there
  // at `to`.
  struct Run {
    Index begin, end, to;
  };
  Index first = 0, pivots = 0;
  std::vector<Index> below;              // rows coupled to the pivots, ascending
  Index parent = -1;                     // receives the update; -1 for roots
  std::vector<Index> children;           // ascending
  Index first_scalar = 0;                // position of the pivots in elimination order
  Index pivot_scalars = 0, scalars = 0;  // scalars of the pivots, and of all rows
  // Positions of the scalars of the rows below: in elimination order, and in the parent front.
  std::vector<Run> runs_in_order, runs_in_parent;
  std::vector<Entry> entries;
};

// The fronts [begin, end): a subtree of the tree of fronts, children before parents.
struct EliminationSubtree {
  Index begin, end;
};

// Subtrees [begin, end), eliminated in parallel. The updates of their roots are added to the parents before the next
// wave.
struct EliminationWave {
  Index begin, end;
};

struct EliminationPlan {
  // The k-th row to be eliminated.
  struct Row {
    Index original;  // its index in the pattern
    Index source;    // index of its first scalar in the matrix
    Index position;  // index of its first scalar in elimination order
    int size;
  };
  std::vector<Row> order;  // all rows, in elimination order
  Index num_scalars = 0;
  std::vector<EliminationFront> fronts;
  // Disjoint subtrees with little work each, each for one thread.
  std::vector<EliminationSubtree> subtrees;
  // All subtrees. The updates of the roots of one wave need at most 64 MiB, unless the wave is a single subtree.
  // Without waves, a front with thousands of child subtrees (such as a camera and its points) would need all their
  // updates in memory at once.
  std::vector<EliminationWave> waves;
  // The fronts that are in no subtree. Fronts of one level depend only on earlier levels.
  std::vector<std::vector<Index>> levels;
  double factor_values = 0;    // number of values of the factor, including zeros in merged fronts
  double update_values = 0;    // number of values in the updates of all fronts
  double multiplications = 0;  // number of multiplications of the factorisation
};

// If a limit is exceeded, PlanElimination returns nothing.
struct EliminationLimits {
  double factor_values = std::numeric_limits<double>::infinity();
  double multiplications = std::numeric_limits<double>::infinity();
};
enum class ExceededLimit { kNone, kFactorValues, kMultiplications };

// Plans the elimination. The order is by approximate minimum degree (Amestoy, Davis, Duff, 1996). A front is merged
// with its parent if the result has few additional zeros (relaxed supernodes, Ashcraft and Grimes, 1989). Returns
// nothing if the factor exceeds the limits even before fronts are merged; this test comes first, because it needs much
// less memory than the plan. exceeded: if not null, set to the first limit found to be exceeded.
std::optional<EliminationPlan> PlanElimination(const BlockPattern& pattern, const EliminationLimits& limits = {},
                                               ExceededLimit* exceeded = nullptr);

// The same plan for blocks of another size. All rows of `plan` have size `from`, all rows of the result size `to`.
EliminationPlan Resized(EliminationPlan plan, int from, int to);

}  // namespace vesta
