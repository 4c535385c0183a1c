#include "splatting/train/session/time_budget.h"

#include <limits>

namespace vesta::gs {

bool TimeBudget::HasTimeToRecord(double seconds) const {
  if (!is_limited()) return true;
  return processes_.OfFirst(clock_.Paused() + seconds <= 0.05 * (clock_.Total() + seconds) ? 1 : 0) > 0;
}

double TimeBudget::SecondsForAdam() const {
  if (!is_limited()) return std::numeric_limits<double>::infinity();
  // Of the limit: what LM gets where it is asked for, and what files take to be written.
  constexpr double kPartOfLm = 0.25, kPartToWrite = 0.01;
  const double kept = kPartToWrite + (options_.lm.iterations > 0 ? kPartOfLm : 0);
  return (1 - kept) * options_.time_limit - clock_.Total();
}

}  // namespace vesta::gs
