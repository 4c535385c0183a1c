// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/blocks/block_distance.h"

#include <algorithm>
#include <vector>

namespace vesta {
namespace {

// Breadth-first search. A residual block, or an eliminated block, is a set of kept blocks that are neighbours.
class Search {
 public:
  explicit Search(const BlockStructure& structure)
      : structure_(structure), block_(structure.free_blocks().size()), row_turn_(structure.rows().size(), 0) {}

  struct Farthest {
    int block, distance;
  };
  Farthest From(int block) {
    ++turn_;
    reached_.clear();
    Reach(block, 0);
    for (std::size_t k = 0; k < reached_.size(); ++k) {
      const int from = reached_[k], next = block_[At(from)].distance + 1;
      for (const BlockUse& use : structure_.uses(from)) Cross(use.row, next);
    }
    return {reached_.back(), block_[At(reached_.back())].distance};
  }
  bool EverReached(int block) const { return block_[At(block)].turn > 0; }

 private:
  struct State {
    int turn = 0;  // of the last search that came here
    int distance = 0;
  };
  static std::size_t At(Index i) { return static_cast<std::size_t>(i); }

  void Cross(Index r, int distance) {
    if (row_turn_[At(r)] == turn_) return;
    row_turn_[At(r)] = turn_;
    for (const BlockCell& cell : structure_.cells(structure_.rows()[At(r)])) Reach(cell.free, distance);
  }
  void Reach(int block, int distance) {
    State& state = block_[At(block)];
    if (state.turn == turn_) return;
    state = {turn_, distance};
    if (block < structure_.num_kept_blocks()) {
      reached_.push_back(block);
    } else {
      for (const BlockUse& use : structure_.uses(block)) Cross(use.row, distance);
    }
  }

  const BlockStructure& structure_;
  int turn_ = 0;
  std::vector<State> block_;
  std::vector<int> row_turn_;
  std::vector<int> reached_;  // kept blocks, in order
};

}  // namespace

int LongestDistance(const BlockStructure& structure) {
  Search search(structure);
  int longest = 0;
  for (int block = 0; block < structure.num_kept_blocks(); ++block) {
    if (search.EverReached(block)) continue;
    longest = std::max(longest, search.From(search.From(block).block).distance);
  }
  return longest;
}

}  // namespace vesta
