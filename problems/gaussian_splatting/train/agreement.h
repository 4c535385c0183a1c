// What processes that train together decide as one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "kernels/ranks/ranks.h"

namespace vesta::gs {

// All that asks others is called by all of them, in the same order. One alone decides by itself.
class Agreement {
 public:
  // null: this process alone.
  explicit Agreement(Ranks* ranks) : ranks_(ranks) {}

  Ranks* ranks() const { return ranks_; }
  // What one process decides by itself, as where its GPU has no room, others do not know of.
  bool is_alone() const { return !ranks_ || ranks_->size() == 1; }
  // Whether what is said by one alone, as by its clock, is this one's to say.
  bool is_first() const { return !ranks_ || ranks_->rank() == 0; }
  // Whether it is so in any of them.
  bool OnAny(bool mine) const { return ranks_ ? OnAnyRank(*ranks_, mine) : mine; }
  // In which of them it is so.
  std::vector<bool> OnEach(bool mine) const {
    const std::vector<std::uint8_t> all = Gathered(static_cast<std::uint8_t>(mine ? 1 : 0));
    return {all.begin(), all.end()};
  }
  // The most that one says, by which all plan.
  double MostOfAll(double mine) const { return std::ranges::max(Gathered(mine)); }
  // What the first says, where each would say something else, as by its clock.
  double OfFirst(double mine) const { return Gathered(mine)[0]; }

 private:
  template <class T>
  std::vector<T> Gathered(T mine) const {
    const std::vector<T> own{mine};
    return is_alone() ? own : GatherValues(*ranks_, own);
  }

  Ranks* ranks_;
};

}  // namespace vesta::gs
