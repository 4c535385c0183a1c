// SPDX-License-Identifier: Apache-2.0
// Place of an iteration in its training stage, as fractions of the stage (0: start, 1: end). Schedules are defined by
// these fractions, so they do not depend on the number of iterations.
#pragma once

#include <algorithm>
#include <cmath>

namespace vesta::gs {

// The fractions of the stage that are completed before an iteration and after it.
struct StageSpan {
  double before = 0, after = 1;

  bool is_last() const { return after >= 1; }
  // True if a multiple of `part` lies in (before, after]. part is a fraction of the stage; with 0 the result is false.
  bool CrossesMultipleOf(double part) const { return part > 0 && Parts(after, part) > Parts(before, part); }
  // floor(before / part), at most 1e9. part > 0.
  int PartsBefore(double part) const { return static_cast<int>(std::min(Parts(before, part), 1e9)); }
  // True if the iteration belongs to the stage up to the fraction `end`.
  bool IsWithin(double end) const { return after <= end + kRounding; }
  // True if the iteration ends at or after the fraction `begin`.
  bool HasReached(double begin) const { return after >= begin - kRounding; }

 private:
  static constexpr double kRounding = 1e-9;  // tolerance for rounded quotients of iteration numbers
  static double Parts(double done, double part) { return std::floor(done / part + kRounding); }
};

}  // namespace vesta::gs
