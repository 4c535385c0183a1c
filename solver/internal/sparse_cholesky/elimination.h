// SPDX-License-Identifier: Apache-2.0
// The plan of a sparse Cholesky factorisation: which rows of blocks are eliminated together, in which order, and where
// each result goes. Depends on the pattern alone.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "solver/internal/sparse_cholesky/block_matrix.h"

namespace vesta {

// A dense front of the multifrontal method (Duff and Reid, 1983). Rows of blocks are numbered in the order of
// elimination. The front eliminates rows first..first + pivots; the rest of its rows is `below`.
struct EliminationFront {
  // A block of the matrix that is first touched here.
  struct Entry {
    Index row, col;  // its first scalar in the front
    int rows, cols;
    Index source;  // diagonal block of this original row, or off-diagonal block of this number
    bool diagonal;
    bool transposed;  // the stored block is that of (col, row)
  };
  // Scalars [begin, end), counted from the first below the pivots, that lie side by side from `to` on elsewhere.
  struct Run {
    Index begin, end, to;
  };
  Index first = 0, pivots = 0;
  std::vector<Index> below;                        // rows that the pivots are joined to, ascending
  Index parent = -1;                               // the front that takes the update; -1: none
  std::vector<Index> children;                     // ascending
  Index first_scalar = 0;                          // in the order of elimination
  Index pivot_scalars = 0, scalars = 0;            // of the pivots, of all rows
  std::vector<Run> runs_in_order, runs_in_parent;  // the rows below in the order of elimination, in the parent's front
  std::vector<Entry> entries;
};

// Fronts such that [begin, end) are a whole subtree: children come before parents.
struct EliminationSubtree {
  Index begin, end;
};

// Subtrees [begin, end) that are eliminated at the same time; their updates are taken up before the next wave begins.
struct EliminationWave {
  Index begin, end;
};

struct EliminationPlan {
  // The row eliminated k-th.
  struct Row {
    Index original;  // its number
    Index source;    // its first scalar in the matrix
    Index position;  // and in the order of elimination
    int size;
  };
  std::vector<Row> order;
  Index num_scalars = 0;
  std::vector<EliminationFront> fronts;
  // Disjoint subtrees of little work each, for threads to take as they come.
  std::vector<EliminationSubtree> subtrees;
  // Of all subtrees, such that the updates of one wave are few tens of MiB or those of a single subtree: a front that
  // thousands of subtrees report to (cameras over points) would otherwise have to wait for the updates of them all.
  std::vector<EliminationWave> waves;
  // The fronts above the subtrees; those of a level need the levels before it and nothing of each other.
  std::vector<std::vector<Index>> levels;
  double factor_values = 0;    // of the factor, with the zeros that joined fronts store
  double update_values = 0;    // that fronts hand on to their parents
  double multiplications = 0;  // to factorise
};

struct EliminationLimits {
  double factor_values = std::numeric_limits<double>::infinity();
  double multiplications = std::numeric_limits<double>::infinity();
};

// Order of elimination by approximate minimum degree (Amestoy, Davis, Duff, 1996); fronts that store few zeros more
// when joined with their parent are joined (relaxed supernodes, Ashcraft and Grimes, 1989). Nothing where the factor
// itself, before fronts are joined, is over the limits: that is known without the memory that the plan takes.
std::optional<EliminationPlan> PlanElimination(const BlockPattern& pattern, const EliminationLimits& limits = {});

}  // namespace vesta
