// The plan of a sparse Cholesky factorisation: which rows of blocks are eliminated together, in which order, and where
// each result goes. Depends on the pattern alone.
#pragma once

#include <vector>

#include "problems/pose_graph/block_matrix.h"

namespace vesta::pose_graph {

// A dense front of the multifrontal method (Duff and Reid, 1983). Rows are numbered in the order of elimination. The
// front eliminates rows first..first + pivots; the rest of its rows is `below`.
struct EliminationFront {
  // A block of the matrix that is first touched here: at (row, col) of the front.
  struct Entry {
    Index row, col;
    Index source;  // diagonal block of this original row, or off-diagonal block of this number
    bool diagonal;
    bool transposed;  // the stored block is that of (col, row)
  };
  Index first = 0, pivots = 0;
  std::vector<Index> below;            // rows that the pivots are joined to, ascending
  Index parent = -1;                   // the front that takes the update; -1: none
  std::vector<Index> place_in_parent;  // of each row of below, in the parent's front
  std::vector<Index> children;         // ascending
  std::vector<Entry> entries;

  Index rows() const { return pivots + static_cast<Index>(below.size()); }
};

// Fronts such that [begin, end) are a whole subtree: children come before parents.
struct EliminationSubtree {
  Index begin, end;
};

struct EliminationPlan {
  std::vector<Index> order;  // order[k]: the original row eliminated k-th
  std::vector<EliminationFront> fronts;
  // Disjoint subtrees of little work each, for threads to take as they come.
  std::vector<EliminationSubtree> subtrees;
  // The fronts above the subtrees; those of a level need the levels before it and nothing of each other.
  std::vector<std::vector<Index>> levels;
  double factor_blocks = 0;    // blocks of the factor, with those that merged fronts store without need
  double multiplications = 0;  // of blocks, to factorise
};

// Order of elimination by approximate minimum degree (Amestoy, Davis, Duff, 1996); fronts that store few zeros more
// when joined with their parent are joined (relaxed supernodes, Ashcraft and Grimes, 1989).
EliminationPlan PlanElimination(const BlockPattern& pattern);

}  // namespace vesta::pose_graph
