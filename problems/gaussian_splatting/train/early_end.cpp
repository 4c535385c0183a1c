#include "problems/gaussian_splatting/train/early_end.h"

#include <limits>

namespace vesta::gs {

bool EarlyEnd::ShouldStop(double ahead) {
  if (options_.time_limit > 0 && clock_.Total() + ahead >= options_.time_limit) stopped_ = true;
  if (callbacks_.stop && callbacks_.stop()) stopped_ = true;
  return stopped_ = together_.OnAny(stopped_);
}

bool EarlyEnd::HasTimeToRecord(double seconds) const {
  if (options_.time_limit <= 0) return true;
  return together_.OfFirst(clock_.Paused() + seconds <= 0.05 * (clock_.Total() + seconds) ? 1 : 0) > 0;
}

double EarlyEnd::SecondsForAdam() const {
  if (options_.time_limit <= 0) return std::numeric_limits<double>::infinity();
  // Of the limit: what LM gets where it is asked for, and what files take to be written.
  constexpr double kPartOfLm = 0.25, kPartToWrite = 0.01;
  const double kept = kPartToWrite + (options_.lm.iterations > 0 ? kPartOfLm : 0);
  return (1 - kept) * options_.time_limit - clock_.Total();
}

}  // namespace vesta::gs
