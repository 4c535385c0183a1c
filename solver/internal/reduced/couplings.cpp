// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/reduced/couplings.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace vesta {

Couplings::Couplings(const BlockStructure& structure) {
  const int num_kept = structure.num_kept_blocks();
  const auto num_eliminated = structure.free_blocks().size() - static_cast<std::size_t>(num_kept);
  first_of_eliminated_.assign(num_eliminated + 1, 0);
  first_of_kept_.push_back(0);
  std::vector<std::pair<int, CouplingTerm>> shared;
  for (int k = 0; k < num_kept; ++k) {
    shared.clear();
    for (const BlockUse& use : structure.uses(k)) {
      const BlockRow& row = structure.rows()[static_cast<std::size_t>(use.row)];
      if (row.eliminated_cell < 0) continue;
      const BlockCell& cell = structure.cells(row)[static_cast<std::size_t>(row.eliminated_cell)];
      shared.push_back({cell.free - num_kept, {use.row, use.local, cell.local}});
    }
    std::stable_sort(shared.begin(), shared.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < shared.size(); ++i) {
      const int e = shared[i].first;
      if (i == 0 || shared[i - 1].first != e) {
        couplings_.push_back({k, e, static_cast<Index>(terms_.size()), 0});
        ++first_of_eliminated_[static_cast<std::size_t>(e) + 1];
      }
      terms_.push_back(shared[i].second);
    }
    first_of_kept_.push_back(couplings_.size());
  }

  std::partial_sum(first_of_eliminated_.begin(), first_of_eliminated_.end(), first_of_eliminated_.begin());
  std::vector<std::size_t> next(first_of_eliminated_.begin(), first_of_eliminated_.end() - 1);
  std::vector<Coupling*> order(couplings_.size());
  for (Coupling& coupling : couplings_) order[next[static_cast<std::size_t>(coupling.eliminated)]++] = &coupling;
  by_eliminated_.reserve(order.size());
  for (Coupling* const coupling : order) {
    coupling->first_value = num_values_;
    by_eliminated_.push_back({coupling->kept, num_values_});
    num_values_ +=
        Index{structure.free_blocks()[static_cast<std::size_t>(coupling->kept)].size} *
        structure.free_blocks()[static_cast<std::size_t>(num_kept) + static_cast<std::size_t>(coupling->eliminated)]
            .size;
  }
  couplings_.push_back({num_kept, 0, static_cast<Index>(terms_.size()), num_values_});
}

}  // namespace vesta
