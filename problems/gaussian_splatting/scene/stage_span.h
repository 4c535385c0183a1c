// SPDX-License-Identifier: Apache-2.0
// Where an iteration lies in its stage. All that changes in the course of a stage does so at parts of it, however many
// iterations they take.
#pragma once

#include <algorithm>
#include <cmath>

namespace vesta::gs {

// The part of the stage that is done before an iteration, and after it.
struct StageSpan {
  double before = 0, after = 1;

  bool is_last() const { return after >= 1; }
  // Whether the iteration reaches a multiple of `part` of the stage; none where that is 0.
  bool CrossesMultipleOf(double part) const { return part > 0 && Parts(after, part) > Parts(before, part); }
  // How many whole parts of that size are done before it; of very small ones some number of very many.
  int PartsBefore(double part) const { return static_cast<int>(std::min(Parts(before, part), 1e9)); }
  // Whether it is of the part up to `end`.
  bool IsWithin(double end) const { return after <= end + kRounding; }
  // Whether it leads to `begin` or beyond.
  bool HasReached(double begin) const { return after >= begin - kRounding; }

 private:
  static constexpr double kRounding = 1e-9;  // of quotients of iterations
  static double Parts(double done, double part) { return std::floor(done / part + kRounding); }
};

}  // namespace vesta::gs
