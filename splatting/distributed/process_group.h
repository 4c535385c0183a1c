// SPDX-License-Identifier: Apache-2.0
// The processes that train one model together.
#pragma once

#include <vector>

#include "kernels/ranks/communicator.h"

namespace vesta::gs {

// All processes have the same scene, options and model. They call what is marked "collective" in the same order. One
// process alone decides by itself.
class ProcessGroup {
 public:
  ProcessGroup() = default;
  // null: this process alone.
  explicit ProcessGroup(Communicator* ranks) : ranks_(ranks) {}

  Communicator* ranks() const { return ranks_; }
  bool is_alone() const { return !ranks_ || ranks_->size() == 1; }
  bool is_first() const { return !ranks_ || ranks_->rank() == 0; }
  // Collective: whether it is so in any of them.
  bool OnAny(bool mine) const { return ranks_ ? OnAnyRank(*ranks_, mine) : mine; }
  // Collective: broadcasts the value of the first process, where each has its own, as by its clock.
  double OfFirst(double mine) const { return Gather(std::vector<double>{mine})[0]; }
  // Collective: the values of all processes, one process after another.
  template <class T>
  std::vector<T> Gather(const std::vector<T>& mine) const {
    return is_alone() ? mine : GatherValues(*ranks_, mine);
  }
  // This process's share of so many pieces of work: consecutive ones, those of the first process first.
  Share OwnShare(std::int64_t count) const {
    return ranks_ ? ShareOf(count, ranks_->size(), ranks_->rank()) : Share{0, count};
  }

 private:
  Communicator* ranks_ = nullptr;
};

}  // namespace vesta::gs
