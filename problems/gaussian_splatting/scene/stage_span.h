// SPDX-License-Identifier: Apache-2.0
// Progress of an iteration in its stage. Schedules depend on the fraction of the stage, not on the number of
// iterations.
#pragma once

#include <algorithm>
#include <cmath>

namespace vesta::gs {

// The fraction of the stage completed before an iteration, and after it.
struct StageSpan {
  double before = 0, after = 1;

  bool is_last() const { return after >= 1; }
  // True if the iteration crosses a multiple of `part`, a fraction of the stage; false if part is 0.
  bool CrossesMultipleOf(double part) const { return part > 0 && Parts(after, part) > Parts(before, part); }
  // Number of whole multiples of `part` before the iteration, at most 1e9.
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
