// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/early_end.h"

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

bool EarlyEnd::ShouldStop(double ahead) {
  const bool is_limited = options_.time_limit > 0 && processes_.is_first();
  if (is_limited && clock_.Total() + ahead >= options_.time_limit) stopped_ = true;
  if (callbacks_.stop && callbacks_.stop()) stopped_ = true;
  return stopped_ = processes_.OnAny(stopped_);
}

}  // namespace vesta::gs
