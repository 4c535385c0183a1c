// SPDX-License-Identifier: Apache-2.0
// Place of an iteration in its training stage, as fractions of the stage (0: start, 1: end), for schedules that do not
// depend on the number of iterations.
#pragma once

#include <algorithm>
#include <cmath>

namespace vesta::gs {

// Fractions of the stage completed before and after an iteration.
struct StageSpan {
  double before = 0, after = 1;

  bool is_last() const { return after >= 1; }
  // True if a multiple of `part`, a fraction of the stage, lies in (before, after]; false if part is 0.
  bool CrossesMultipleOf(double part) const { return part > 0 && Parts(after, part) > Parts(before, part); }
  // floor(before / part), at most 1e9. part > 0.
  int PartsBefore(double part) const { return static_cast<int>(std::min(Parts(before, part), 1e9)); }
  // True if the iteration ends within the fraction `end`.
  bool IsWithin(double end) const { return after <= end + kRounding; }
  // True if it ends at or after the fraction `begin`.
  bool HasReached(double begin) const { return after >= begin - kRounding; }

 private:
  static constexpr double kRounding = 1e-9;  // tolerance for rounded quotients of iteration numbers
  static double Parts(double done, double part) { return std::floor(done / part + kRounding); }
};

}  // namespace vesta::gs
