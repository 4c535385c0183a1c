// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/blocks/block_structure.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

namespace vesta {

namespace {

// Smallest fraction of the unknowns that makes elimination worthwhile. Below it, the Schur complement is not much
// smaller than the full system.
constexpr double kWorthEliminating = 0.6;

std::vector<bool> FindEliminated(std::span<const ParameterBlock> parameters, const ResidualBlockList& residuals) {
  std::vector<std::vector<std::size_t>> rows_of(parameters.size());
  for (std::size_t r = 0; r < residuals.size(); ++r) {
    for (const int p : residuals[r].parameters) {
      if (parameters[static_cast<std::size_t>(p)].tangent_size > 0) rows_of[static_cast<std::size_t>(p)].push_back(r);
    }
  }
  std::vector<std::size_t> order;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (!rows_of[p].empty()) order.push_back(p);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rows_of[a].size() < rows_of[b].size(); });
  std::vector<bool> eliminated(parameters.size(), false), taken(residuals.size(), false);
  Index total = 0, found = 0;
  for (const std::size_t p : order) {
    total += parameters[p].tangent_size;
    const bool independent =
        std::none_of(rows_of[p].begin(), rows_of[p].end(), [&](std::size_t r) { return taken[r]; });
    if (!independent) continue;
    eliminated[p] = true;
    found += parameters[p].tangent_size;
    for (const std::size_t r : rows_of[p]) taken[r] = true;
  }
  const bool worth = found < total && static_cast<double>(found) >= kWorthEliminating * static_cast<double>(total);
  if (!worth) eliminated.assign(parameters.size(), false);
  return eliminated;
}

std::vector<bool> FindUsed(std::size_t num_parameters, const ResidualBlockList& residuals) {
  std::vector<bool> used(num_parameters, false);
  for (std::size_t r = 0; r < residuals.size(); ++r) {
    for (const int p : residuals[r].parameters) used[static_cast<std::size_t>(p)] = true;
  }
  return used;
}

}  // namespace

std::size_t ResidualBlockList::Add(const ResidualBlock& block) {
  const auto count = static_cast<int>(block.parameters.size());
  if (const auto empty = empty_.find(count); empty != empty_.end()) {
    const std::size_t k = empty->second.back();
    empty->second.pop_back();
    if (empty->second.empty()) empty_.erase(empty);
    --num_empty_;
    slots_[k].num_parameters = count;
    slots_[k].num_residuals = block.num_residuals;
    std::copy(block.parameters.begin(), block.parameters.end(),
              parameters_.begin() + static_cast<std::ptrdiff_t>(slots_[k].first));
    return k;
  }
  slots_.push_back({parameters_.size(), count, block.num_residuals});
  parameters_.insert(parameters_.end(), block.parameters.begin(), block.parameters.end());
  return slots_.size() - 1;
}

void ResidualBlockList::Remove(std::size_t k) {
  empty_[slots_[k].num_parameters].push_back(k);
  ++num_empty_;
  slots_[k].num_parameters = slots_[k].num_residuals = 0;
}

BlockStructure::BlockStructure(std::span<const ParameterBlock> parameters, const ResidualBlockList& residuals,
                               bool eliminate) {
  const std::vector<bool> eliminated =
      eliminate ? FindEliminated(parameters, residuals) : std::vector<bool>(parameters.size(), false);
  NumberFreeBlocks(parameters, FindUsed(parameters.size(), residuals), eliminated);
  PlaceRows(residuals, eliminated);
  ListUses();
}

void BlockStructure::NumberFreeBlocks(std::span<const ParameterBlock> parameters, const std::vector<bool>& used,
                                      const std::vector<bool>& eliminated) {
  std::vector<int> order;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].tangent_size > 0 && used[p]) order.push_back(static_cast<int>(p));
  }
  const auto key = [&](int p) {
    const auto k = static_cast<std::size_t>(p);
    return std::tuple(static_cast<bool>(eliminated[k]), parameters[k].tangent_size);
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  free_of_.assign(parameters.size(), -1);
  for (const int p : order) {
    const bool last_part = eliminated[static_cast<std::size_t>(p)];
    const int size = parameters[static_cast<std::size_t>(p)].tangent_size;
    std::vector<BlockGroup>& part = last_part ? eliminated_groups_ : kept_groups_;
    if (!last_part) {
      num_kept_ = num_tangent_ + size;
      ++num_kept_blocks_;
    }
    if (part.empty() || part.back().size != size) {
      const Index start = last_part ? num_kept_ : 0;
      part.push_back({size, 0, num_tangent_ - start, 1, size});
      groups_.push_back({size, 0, num_tangent_, 1, size});
    }
    free_of_[static_cast<std::size_t>(p)] = static_cast<int>(free_.size());
    free_.push_back({p, size, num_tangent_, static_cast<int>(groups_.size()) - 1, groups_.back().count});
    ++part.back().count;
    ++groups_.back().count;
    num_tangent_ += size;
  }
}

void BlockStructure::PlaceRows(const ResidualBlockList& residuals, const std::vector<bool>& eliminated) {
  rows_.reserve(residuals.size());
  cells_.reserve(residuals.num_arguments());
  for (std::size_t r = 0; r < residuals.size(); ++r) {
    const ResidualBlock residual = residuals[r];
    if (residual.num_residuals == 0) continue;  // an empty slot
    BlockRow row{.residual_block = static_cast<Index>(r),
                 .residual_offset = num_residuals_,
                 .value_offset = 0,
                 .num_residuals = residual.num_residuals,
                 .first_cell = static_cast<Index>(cells_.size())};
    for (std::size_t argument = 0; argument < residual.parameters.size(); ++argument) {
      const auto p = static_cast<std::size_t>(residual.parameters[argument]);
      const int free = free_of_[p];
      if (free < 0) continue;
      if (eliminated[p]) row.eliminated_cell = row.num_cells;
      const FreeBlock& block = free_[static_cast<std::size_t>(free)];
      cells_.push_back({free, static_cast<int>(argument), row.width, block.size, block.offset});
      row.width += block.size;
      ++row.num_cells;
    }
    if (row.num_cells == 0) {
      fixed_residual_blocks_.push_back(row.residual_block);
      continue;
    }
    num_residuals_ += row.num_residuals;
    rows_.push_back(row);
  }
  // Store the values in the usual order of access: all rows of an eliminated block together.
  std::vector<std::pair<int, std::size_t>> order;
  order.reserve(rows_.size());
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const BlockRow& row = rows_[r];
    order.emplace_back(
        row.eliminated_cell < 0 ? -1 : cells_[static_cast<std::size_t>(row.first_cell + row.eliminated_cell)].free, r);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [eliminated_block, r] : order) {
    rows_[r].value_offset = num_values_;
    num_values_ += static_cast<Index>(rows_[r].num_residuals) * rows_[r].width;
  }
}

void BlockStructure::ListUses() {
  first_use_.assign(free_.size() + 1, 0);
  for (const BlockCell& cell : cells_) ++first_use_[static_cast<std::size_t>(cell.free) + 1];
  std::partial_sum(first_use_.begin(), first_use_.end(), first_use_.begin());
  uses_.resize(cells_.size());
  std::vector<std::size_t> next(first_use_.begin(), first_use_.end() - 1);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (const BlockCell& cell : cells(rows_[r])) {
      uses_[next[static_cast<std::size_t>(cell.free)]++] = {static_cast<Index>(r), cell.local};
    }
  }
}

namespace {

// Breadth-first search. The kept blocks of one residual block, or of one eliminated block, are neighbours.
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
    int turn = 0;  // of the last search that reached it
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
  std::vector<int> reached_;  // kept blocks, in the order of the search
};

}  // namespace

int LongestDistanceLowerBound(const BlockStructure& structure) {
  Search search(structure);
  int longest = 0;
  for (int block = 0; block < structure.num_kept_blocks(); ++block) {
    if (search.EverReached(block)) continue;
    longest = std::max(longest, search.From(search.From(block).block).distance);
  }
  return longest;
}

}  // namespace vesta
