// SPDX-License-Identifier: Apache-2.0
// The MPI processes that train one model together.
#pragma once

#include <vector>

#include "kernels/ranks/communicator.h"

namespace vesta::gs {

// Processes with the same scene, options and model, possibly one alone. Every process must call functions marked
// "collective", in the same order.
class ProcessGroup {
 public:
  ProcessGroup() = default;
  // null: this process only.
  explicit ProcessGroup(Communicator* ranks) : ranks_(ranks) {}

  Communicator* ranks() const { return ranks_; }
  bool is_alone() const { return !ranks_ || ranks_->size() == 1; }
  bool is_first() const { return !ranks_ || ranks_->rank() == 0; }
  // Collective: true if `mine` is true on any process.
  bool OnAny(bool mine) const { return ranks_ ? OnAnyRank(*ranks_, mine) : mine; }
  // Collective: rank 0's value, for values that differ between processes, such as times.
  double OfFirst(double mine) const { return Gather(std::vector<double>{mine})[0]; }
  // Collective: the values of all processes, by rank.
  template <class T>
  std::vector<T> Gather(const std::vector<T>& mine) const {
    return is_alone() ? mine : GatherValues(*ranks_, mine);
  }
  // This process's share of `count` work items: consecutive, in the order of ranks.
  Share OwnShare(std::int64_t count) const {
    return ranks_ ? ShareOf(count, ranks_->size(), ranks_->rank()) : Share{0, count};
  }

 private:
  Communicator* ranks_ = nullptr;
};

}  // namespace vesta::gs
